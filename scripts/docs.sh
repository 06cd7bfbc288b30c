#!/bin/bash
# Makes the site: guides and reference, build/docs/html/index.html. What Doxygen warns of fails.
set -euo pipefail
cd "$(dirname "$0")/.."

rm -rf build/docs
mkdir -p build/docs
doxygen docs/Doxyfile

# Links that Doxygen could not place it leaves as they are: to files that the site does not have.
if grep -rnoE 'href="[^"#:]*\.md[^"]*"' build/docs/html --include='*.html'; then
  echo "these links lead nowhere" >&2
  exit 1
fi
echo "build/docs/html/index.html"
