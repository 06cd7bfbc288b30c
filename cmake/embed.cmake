# leadline_embed(<target> <span> HEADER <header> FILES <file>...)
#
# Puts text files into a program: adds to <target> a generated source file that defines <span>, the
# std::span<const EmbeddedFile> that <header> declares, with the name and the text of every file.
# The same file, run as a script, writes that source file at build time.

if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(LEADLINE_EMBED_SCRIPT "${CMAKE_CURRENT_LIST_FILE}")

  function(leadline_embed target span)
    cmake_parse_arguments(PARSE_ARGV 2 arg "" "HEADER" "FILES")
    set(output "${CMAKE_CURRENT_BINARY_DIR}/${span}.cc")
    list(JOIN arg_FILES "|" files)
    add_custom_command(
      OUTPUT "${output}"
      COMMAND "${CMAKE_COMMAND}" "-DOUTPUT=${output}" "-DSPAN=${span}" "-DHEADER=${arg_HEADER}" "-DFILES=${files}"
              -P "${LEADLINE_EMBED_SCRIPT}"
      DEPENDS ${arg_FILES} "${LEADLINE_EMBED_SCRIPT}"
      COMMENT "Embedding the files of ${span}"
      VERBATIM)
    target_sources(${target} PRIVATE "${output}")
    # The standard asks compilers for string literals of 64 KiB only; GCC and Clang take any.
    set_source_files_properties("${output}" PROPERTIES COMPILE_OPTIONS -Wno-overlength-strings)
  endfunction()
  return()
endif()

string(REPLACE "|" ";" FILES "${FILES}")
set(entries "")
foreach(file IN LISTS FILES)
  file(READ "${file}" text)
  get_filename_component(name "${file}" NAME)
  string(APPEND entries "    {\"${name}\", R\"EMBEDDED(${text})EMBEDDED\"sv},\n")
endforeach()
file(WRITE "${OUTPUT}" "#include \"${HEADER}\"

namespace leadline::app {
namespace {

using namespace std::string_view_literals;

constexpr EmbeddedFile kFiles[] = {
${entries}};

}  // namespace

const std::span<const EmbeddedFile> ${SPAN}{kFiles};

}  // namespace leadline::app
")
