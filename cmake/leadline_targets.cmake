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
# library is installed with its headers and found by find_package(leadline); BUILD_SHARED_LIBS says whether it
# is a shared one. All others are static.
#
# The number in the soname changes with every version that find_package() takes for incompatible.
function(leadline_add_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "EXPORTED" "" "DEPENDS")
  set(target leadline_${name})

  file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/src/*.cc")
  if(sources)
    if(arg_EXPORTED)
      set(type "")
    else()
      set(type STATIC)
    endif()
    add_library(${target} ${type} ${sources})
    set(scope PUBLIC)
    leadline_set_warnings(${target})
    # No DEFINE_SYMBOL: both kinds are made of the same objects. Shared ones find each other beside themselves.
    set_target_properties(${target} PROPERTIES
      POSITION_INDEPENDENT_CODE ON
      DEFINE_SYMBOL ""
      INSTALL_RPATH "$ORIGIN"
      VERSION ${leadline_VERSION}
      SOVERSION ${leadline_VERSION_MAJOR}.${leadline_VERSION_MINOR})
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

# leadline_add_room(<name> USES <room or target>...)
#
# Library leadline_app_<name> of the sources in this folder's <name>/. A room's headers are "apps/<name>/...";
# they are found by the room itself and by those that use it, at first or second hand, and by nobody else: an
# include against the arrows does not compile.
function(leadline_add_room name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "USES")
  set(target leadline_app_${name})
  set(include_dir "${PROJECT_BINARY_DIR}/include/${name}")
  file(MAKE_DIRECTORY "${include_dir}/apps")
  file(CREATE_LINK "${CMAKE_CURRENT_SOURCE_DIR}/${name}" "${include_dir}/apps/${name}" SYMBOLIC)

  file(GLOB sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.cc")
  list(FILTER sources EXCLUDE REGEX "/main\\.cc$")
  add_library(${target} STATIC ${sources})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC "${include_dir}")
  list(TRANSFORM arg_USES REPLACE "^(support|wire|keys|config|recordings|maps|evaluation|node|results|report)$"
                                  "leadline_app_\\1")
  target_link_libraries(${target} PUBLIC ${arg_USES})
  leadline_set_warnings(${target})
  if(LEADLINE_BUILD_FUZZERS)
    target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link)  # they are led by what it covers
  endif()
endfunction()
