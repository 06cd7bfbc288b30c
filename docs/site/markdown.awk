#!/usr/bin/awk -f
# Markdown as Doxygen wants it, from Markdown as the rest of the world reads it: every heading below the first
# gets the anchor that links to it use, made unique by the file's name, and links to headings follow.
# The page of the examples gets their text.
FNR == 1 {
  page = FILENAME
  sub(/.*\//, "", page)
  sub(/\.md$/, "", page)
}
/^```/ { code = !code }
!code && /^##+ / {
  slug = $0
  sub(/^#+ /, "", slug)
  slug = tolower(slug)
  gsub(/[^a-z0-9 _-]/, "", slug)
  gsub(/ /, "-", slug)
  if (seen[slug]++) slug = slug "-" seen[slug] - 1
  $0 = $0 " {#" page "-" slug "}"
}
!code {
  gsub(/\]\(#/, "](#" page "-")
  while (match($0, /\]\(examples\/[a-z0-9_]+\.cc\)/)) {
    example = substr($0, RSTART + 11, RLENGTH - 12)
    examples[++count] = example
    sub(/\.cc$/, "", example)
    $0 = substr($0, 1, RSTART + 1) "#examples-" example substr($0, RSTART + RLENGTH - 1)
  }
  while (match($0, /\]\([A-Za-z_\/.]+\.md#/)) {  # of another page
    other = substr($0, RSTART + 2, RLENGTH - 6)
    sub(/.*\//, "", other)
    $0 = substr($0, 1, RSTART + 1) "#" other "-" substr($0, RSTART + RLENGTH)
  }
}
{ print }
END {
  if (page != "examples") exit
  for (i = 1; i <= count; ++i) {
    name = examples[i]
    sub(/\.cc$/, "", name)
    printf "\n## %s {#examples-%s}\n\\include %s\n", examples[i], name, examples[i]
  }
}
