# Helpers that every folder's CMakeLists.txt uses.

# Warnings for everyone; they are errors only in the presets of this repository. GCC 12 falsely sees
# uninitialized values and accesses out of bounds in inlined code of Eigen; the sanitizers do not. Clang's
# -Wconversion means signs, too, GCC's does not.
function(leadline_set_warnings target)
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Wconversion -Wnon-virtual-dtor -Woverloaded-virtual
    -Wold-style-cast -Wcast-align -Wdouble-promotion -Wformat=2
    "$<$<CXX_COMPILER_ID:GNU>:-Wshadow=local;-Wduplicated-cond;-Wlogical-op;-Wno-maybe-uninitialized;-Wno-array-bounds>"
    $<$<CXX_COMPILER_ID:Clang>:-Wno-sign-conversion>)
endfunction()

# leadline_add_library(<name> [EXPORTED] DEPENDS <target>...)
#
# Library leadline_<name>, alias leadline::<name>, of the folder's include/ and src/. An EXPORTED
# library is installed with its headers and found by find_package(leadline).
function(leadline_add_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "EXPORTED" "" "DEPENDS")
  set(target leadline_${name})

  file(GLOB sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/src/*.cc")
  if(sources)
    add_library(${target} STATIC ${sources})
    set(scope PUBLIC)
    leadline_set_warnings(${target})
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(leadline::${name} ALIAS ${target})

  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(${target} ${scope} cxx_std_20)
  target_include_directories(${target} ${scope}
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} ${scope} ${arg_DEPENDS})

  if(arg_EXPORTED)
    install(TARGETS ${target} EXPORT leadlineTargets)
    install(DIRECTORY include/leadline DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} OPTIONAL)
  endif()
endfunction()
