#!/bin/bash
# Runs clang-tidy: scripts/clang_tidy.sh [BASE]. Warnings (-w) are the builds' affair.
#
# Checked are all files that differ from the commit BASE, however many they are, and a seventh of the others:
# another seventh after each commit, so that seven commits see all. Reading a file's headers takes two thirds of
# the time, whatever is looked for, so every file gets all checks or none, and files of one library are read
# together, as the presets compile them.
#
# BASE is by default where this branch left origin/main; on main itself, ten commits back, or the first commit
# that a shallow clone has. A file that has merely moved is not different. A header that is, is checked through
# a source that includes it.
set -euo pipefail
cd "$(dirname "$0")/.."

readonly shares=7

default_base() {
  local base
  base="$(git merge-base HEAD origin/main 2>/dev/null || true)"
  if [[ -z "$base" || "$base" == "$(git rev-parse HEAD)" ]]; then
    base="$(git rev-list --first-parent --max-count=11 HEAD | tail -n 1)"
  fi
  echo "$base"
}

sources() {
  git ls-files '*.cc' | grep -E '^(core|vehicle|submap|sonar_sim|apps|bench)/'
}

# The source of a header's own name, else the first that includes it.
source_of() {
  local header="$1" name
  name="$(basename "$header" .h)"
  { sources | grep -E "/$name\.cc$" || git grep -lF "/$(basename "$header")\"" -- core vehicle submap sonar_sim apps bench |
    grep -E '\.cc$' || true; } | awk 'NR == 1'
}

changed() {
  git diff --name-only --diff-filter=d --find-renames "$1" -- '*.h' '*.cc' |
    grep -vxFf <(git diff --name-status --find-renames "$1" | awk '$1 == "R100" { print $3 }') |
    while read -r file; do
      if [[ "$file" == *.h ]]; then source_of "$file"; else echo "$file"; fi
    done | sort -u | comm -12 - <(sources | sort)
}

readonly database=build/tidy together=build/tidy/together

# How each source is compiled by itself: the presets compile several as one.
compile_commands() {
  cmake -S . -B "$database" -G Ninja -DCMAKE_BUILD_TYPE=Release -DLEADLINE_BUILD_TESTS=OFF >/dev/null
  cmake --build "$database" --target leadline_lcmtypes_headers >/dev/null
}

# Sources of the same library, up to six, as one that includes them: reads names of sources, writes the files of
# $together with a compilation database of their own, and tells their names.
put_together() {
  rm -rf "$together"
  mkdir -p "$together"
  awk -v root="$PWD/" -v folder="$PWD/$together/" '
    NR == FNR { wanted[root $0] = 1; next }
    /"directory":/ { directory = $0 }
    /"command":/ { command = $0 }
    /"file":/ {
      split($0, quoted, "\"")
      file = quoted[4]
      if (!(file in wanted)) next
      target = command
      sub(/.* -o /, "", target)
      sub(/\.dir\/.*/, "", target)
      if (count[target]++ % 6 == 0) {
        unit[target] = folder (++units) ".cc"
        compiled = command
        sub(/ -o .*/, " -c " unit[target] "\",", compiled)
        printf "%s{\n%s\n%s\n  \"file\": \"%s\"\n}", (units == 1 ? "[" : ",\n"), directory, compiled, unit[target] \
          >(folder "compile_commands.json")
        print unit[target]
      }
      printf "#include \"%s\"\n", file >unit[target]
    }
    END { if (units) print "]" >(folder "compile_commands.json") }' - "$database/compile_commands.json"
}

check() {
  local output
  if ! output="$(clang-tidy -p "$together" --quiet --extra-arg=-w --checks=-bugprone-suspicious-include \
    --config-file=.clang-tidy --header-filter="^$PWD/(core|vehicle|submap|sonar_sim|apps|bench)/" "$1" 2>&1)"; then
    printf '%s\n' "$output"
    return 1
  fi
}
export -f check
export together

compile_commands
base="${1:-$(default_base)}"
share=$(($(git rev-list --count HEAD) % shares))
mapfile -t different < <(changed "$base")
mapfile -t others < <(comm -13 <(printf '%s\n' "${different[@]}") <(sources | sort) |
  awk -v share="$share" -v shares="$shares" 'NR % shares == share')

echo "checking ${#different[@]} files that differ from $(git rev-parse --short "$base")," \
  "and share $((share + 1)) of $shares of the others: ${others[*]}"
printf '%s\n' "${different[@]}" "${others[@]}" | sed '/^$/d' | put_together |
  xargs -r -n 1 -P "$(nproc)" bash -c 'check "$1"' _
