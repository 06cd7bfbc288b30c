# Finds D3, the JavaScript library that the report page carries: D3_JS, the minified file. Debian has
# version 5 in node-d3; its libjs-d3 is version 3.
find_file(D3_JS d3.min.js PATHS /usr/share /usr/local/share PATH_SUFFIXES nodejs/d3/dist)
mark_as_advanced(D3_JS)

if(D3_JS)
  file(READ "${D3_JS}" licence_line LIMIT 100)
  string(REGEX MATCH "d3js\\.org v([0-9.]+)" _ "${licence_line}")
  set(D3_VERSION "${CMAKE_MATCH_1}")
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(D3 REQUIRED_VARS D3_JS VERSION_VAR D3_VERSION HANDLE_VERSION_RANGE)
