#!/usr/bin/awk -f
# Markdown as Doxygen wants it, from Markdown as the rest of the world reads it: every heading below the first
# gets the anchor that links to it use, made unique by the file's name, and links to headings follow.
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
  gsub(/\]\(examples\//, "](@ref ")
  while (match($0, /\]\([A-Za-z_\/.]+\.md#/)) {  # of another page
    other = substr($0, RSTART + 2, RLENGTH - 6)
    sub(/.*\//, "", other)
    $0 = substr($0, 1, RSTART + 1) "#" other "-" substr($0, RSTART + RLENGTH)
  }
}
{ print }
