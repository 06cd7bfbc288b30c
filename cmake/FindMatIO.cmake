# Finds matio, the reader of MATLAB files, for which Debian ships no CMake files: target MatIO::matio.
find_path(MATIO_INCLUDE_DIR matio.h)
find_library(MATIO_LIBRARY matio)
mark_as_advanced(MATIO_INCLUDE_DIR MATIO_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(MatIO REQUIRED_VARS MATIO_LIBRARY MATIO_INCLUDE_DIR)

if(MatIO_FOUND AND NOT TARGET MatIO::matio)
  add_library(MatIO::matio UNKNOWN IMPORTED)
  set_target_properties(MatIO::matio PROPERTIES
    IMPORTED_LOCATION "${MATIO_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${MATIO_INCLUDE_DIR}")
endif()
