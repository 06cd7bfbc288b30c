#!/bin/bash
# Do the tests notice when the estimator is wrong? Changes one place of the library code at a time, in a copy of
# the tree, and runs the tests that must turn red. See scripts/mutate.sh --help.
set -euo pipefail
cd "$(dirname "$0")/.."

usage() {
  cat <<HELP
Changes one place of core/, vehicle/ or submap/ at a time (a mutant), in a copy of the tree, and runs the tests of
the folder and of the one above it. A mutant that no test notices has survived: a behaviour that no test holds.

  scripts/mutate.sh [--count N] [--seed S] [--folder core|vehicle|submap]... [--at-least PERCENT]
  scripts/mutate.sh --from K ...      go on with mutant K of the run before with the same seed and folders
  scripts/mutate.sh --survivors ...   try those again that survived it, after a new test
  scripts/mutate.sh --list ...        only say what would be changed

  --count N        how many mutants that compile, 60 if not told
  --seed S         which ones, 1 if not told: equal trees and seeds give equal mutants
  --folder F       only of this folder; may be given more than once
  --at-least P     exit code 1 if fewer than P percent were killed

A mutant that does not compile is not counted, and the next one taken. One that hangs is killed, in both senses.
Changes that no test could notice (reserve) or none should (defaults) are in scripts/mutants_excluded.txt, each
with its reason; add what you find equivalent. Copy, build and journal are in build/mutate; ccache helps much.
The first build takes minutes, a mutant in a source file a quarter of one, one in a header up to five: all 60 an hour.

  scripts/mutate.sh --folder submap --count 10
HELP
}

refuse() {
  echo "$0: $1; see $0 --help" >&2
  exit 2
}

count=60 seed=1 from=1 folders=() at_least=0 mode=run
while [[ $# -gt 0 ]]; do
  case "$1" in
    --help | -h) usage; exit 0 ;;
    --list | --survivors) mode="${1#--}"; shift; continue ;;
    --count | --seed | --from | --at-least)
      [[ "${2:-}" =~ ^[0-9]{1,6}$ ]] || refuse "$1 is '${2:-}', must be a whole number" ;;&
    --count) count="$2" ;;
    --seed) seed="$2" ;;
    --from) from="$2"; [[ "$from" -ge 1 ]] || refuse "--from is '$from', must be at least 1" ;;
    --at-least) at_least="$2" ;;
    --folder)
      case "${2:-}" in
        core | vehicle | submap) folders+=("$2") ;;
        *) refuse "--folder is '${2:-}', must be core, vehicle or submap" ;;
      esac ;;
    *) refuse "unknown argument '$1'" ;;
  esac
  shift 2
done
[[ ${#folders[@]} -gt 0 ]] || folders=(core vehicle submap)

work="$PWD/build/mutate"
tree="$work/tree" build="$work/build"
run="$seed-$(IFS=-; echo "${folders[*]}")"
journal="$work/journal-$run.tsv"
mkdir -p "$work"

# Every mutant of the folders in the order of the seed: an operator first, then one of its places, so that the
# many constants do not crowd out the rest; no two on one line. The generator is Park and Miller's.
choose() {
  local sources=()
  for folder in "${folders[@]}"; do
    mapfile -t -O "${#sources[@]}" sources < <(git ls-files -co --exclude-standard -- "$folder/src" \
      "$folder/include" | LC_ALL=C sort)
  done
  awk -v excluded=scripts/mutants_excluded.txt -f scripts/mutants.awk "${sources[@]}" |
    awk -F '\t' -v seed="$seed" '
      function random(n) { state = state * 16807 % 2147483647; return int(state / 2147483647 * n) }
      { if (!($1 in size)) name[++operators] = $1; place[$1, size[$1]++] = $0 }
      END {
        state = seed * 7919 % 2147483646 + 1
        for (i = 0; i < 10; ++i) random(1)
        while (operators > 0) {
          o = 1 + random(operators)
          k = random(size[name[o]])
          line = place[name[o], k]
          place[name[o], k] = place[name[o], --size[name[o]]]
          if (size[name[o]] == 0) name[o] = name[operators--]
          split(line, field, "\t")
          if (!seen[field[2], field[3]]++) print line
        }
      }'
}

if [[ "$mode" == list ]]; then
  choose | awk -F '\t' -v count="$count" 'NR <= count { printf "%s:%d:%d  %s  -> %s\n", $2, $3, $4, $1, $6 }'
  exit 0
fi

# The libraries' sources, to which a journal belongs.
sources_sum() {
  git ls-files -co --exclude-standard -- core vehicle submap | LC_ALL=C sort | xargs cat | cksum | tr ' ' -
}

copy_tree() {
  rm -rf "$tree"
  mkdir -p "$tree"
  git ls-files -co --exclude-standard | while read -r file; do [[ ! -f "$file" ]] || echo "$file"; done |
    tar -c -T - | tar -x -C "$tree"
}

# All assertions on, as in preset debug: they are part of what must notice.
configure() {
  local launcher=()
  ! command -v ccache >/dev/null || launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  cmake -S "$tree" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=None "${launcher[@]}" \
    -DCMAKE_CXX_FLAGS="-O1 -w -D_GLIBCXX_ASSERTIONS" \
    -DLEADLINE_BUILD_APPS=OFF -DLEADLINE_BUILD_BENCH=OFF -DLEADLINE_BUILD_TESTS=ON >/dev/null
}

programs_of() {
  case "$1" in
    core) echo core_test vehicle_test ;;
    vehicle) echo vehicle_test submap_test ;;
    submap) echo submap_test ;;
  esac
}

# test_program PROGRAM FILTER SECONDS: the name of the first test that fails; nothing if all pass.
test_program() {
  local output="$work/output" code=0
  timeout -s KILL "$3" "$build/tests/$1" --gtest_fail_fast --gtest_brief=1 --gtest_filter="$2" \
    </dev/null >"$output" 2>&1 || code=$?
  if [[ $code -ne 0 ]]; then
    if grep -q '^\[  FAILED  \]' "$output"; then
      sed -n 's/^\[  FAILED  \] \([^ ,]*\).*/\1/p' "$output" | head -n 1
    elif [[ $code -eq 137 || $code -eq 124 ]]; then
      echo "the time limit of $3 s"
    else
      echo "the end of the program ($(grep -m 1 -iE 'assert' "$output" | cut -c 1-120 || true))"
    fi
  fi
}

# The unchanged tree must pass; which tests are slow, and how long all may take.
baseline() {
  local start program output
  for program in $(for folder in "${folders[@]}"; do programs_of "$folder"; done | tr ' ' '\n' | sort -u); do
    echo "building and running $program of the unchanged tree"
    ninja -C "$build" "$program" >"$work/build.log" 2>&1 || { tail -n 30 "$work/build.log"; exit 3; }
    output="$work/baseline-$program"
    start=$SECONDS
    if ! "$build/tests/$program" </dev/null >"$output" 2>&1; then
      echo "$0: the unchanged tree fails: $(grep '^\[  FAILED  \]' "$output" | tail -n 1)" >&2
      exit 3
    fi
    slow[$program]="$(sed -n 's/^\[       OK \] \([^ ]*\) (\([0-9]*\) ms)$/\2 \1/p' "$output" |
      awk '$1 > 150 { printf "%s%s", separator, $2; separator = ":" }')"
    limit[$program]=$((20 + 6 * (SECONDS - start)))
  done
}
declare -A slow limit

# try FILE LINE COLUMN SIZE INSTEAD: makes the mutant; sets verdict and what killed it.
try() {
  local file="$1" folder="${1%%/*}" program name
  LINE="$2" COLUMN="$3" SIZE="$4" INSTEAD="$5" awk '
    NR != ENVIRON["LINE"] { print; next }
    {
      column = ENVIRON["COLUMN"]
      print substr($0, 1, column - 1) ENVIRON["INSTEAD"] substr($0, column + ENVIRON["SIZE"])
    }' "$file" >"$tree/$file"
  verdict=survived killer=
  for program in $(programs_of "$folder"); do
    if ! timeout -s KILL 1800 ninja -C "$build" "$program" >"$work/build.log" 2>&1; then
      verdict="not compiled"
      return
    fi
    killer="$(test_program "$program" "*-${slow[$program]}" "${limit[$program]}")"
    [[ -n "$killer" || -z "${slow[$program]}" ]] ||
      killer="$(test_program "$program" "${slow[$program]}" "${limit[$program]}")"
    if [[ -n "$killer" ]]; then
      verdict=killed
      return
    fi
  done
}

restore() {
  cp -p "$1" "$tree/$1"
  touch "$tree/$1"  # what was built of the mutant is older than this
}

# report NUMBER OPERATOR FILE LINE SECONDS
report() {
  printf '[%s/%s] %s:%s  %s: %s%s (%d s)\n' "$1" "$count" "$3" "$4" "$2" "$verdict" "${killer:+ by $killer}" "$5"
  diff "$3" "$tree/$3" | sed -n 's/^[<>]/    &/p' | sed 's/^    </    -/; s/^    >/    +/' || true
}

# The sites to try, those before them being in the journal.
prepare_journal() {
  local sum kept
  sum="$(sources_sum)"
  if [[ "$mode" == run && "$from" -eq 1 ]]; then
    printf 'sources\t%s\n' "$sum" >"$journal"
    return
  fi
  [[ -f "$journal" ]] || refuse "there is no run before with seed $seed and these folders"
  [[ "$(sed -n 's/^sources\t//p' "$journal")" == "$sum" ]] ||
    refuse "core, vehicle or submap have changed since the run before; start anew"
  [[ "$mode" == run ]] || return 0
  kept="$(awk -F '\t' -v from="$from" 'NR == 1 || $1 < from' "$journal")"
  printf '%s\n' "$kept" >"$journal"
}

run_mutants() {
  local number="$from" operator file line column size instead tried start
  tried="$(awk -F '\t' 'NR > 1 { print $4 ":" $5 }' "$journal")"
  while IFS=$'\t' read -r -u 3 operator file line column size instead; do
    [[ "$number" -le "$count" ]] || break
    ! grep -qxF "$file:$line" <<<"$tried" || continue
    start=$SECONDS
    try "$file" "$line" "$column" "$size" "$instead"
    if [[ "$verdict" == "not compiled" ]]; then
      echo "        $file:$line  $operator: does not compile ($((SECONDS - start)) s)"
    else
      report "$number" "$operator" "$file" "$line" $((SECONDS - start))
    fi
    printf '%s\t%s\t%s\t%s\t%s\t%s\t%s\t%s\n' "$number" "$verdict" "$operator" "$file" "$line" "$column" \
      "$size" "$instead" >>"$journal"
    [[ "$verdict" == "not compiled" ]] || number=$((number + 1))
    restore "$file"
  done 3< <(choose)
}

try_survivors() {
  local number old operator file line column size instead start
  cp "$journal" "$work/journal-before.tsv"
  count="$(awk -F '\t' '$2 == "killed" || $2 == "survived"' "$journal" | wc -l)"
  head -n 1 "$work/journal-before.tsv" >"$journal"
  while IFS=$'\t' read -r -u 3 number old operator file line column size instead; do
    verdict="$old"
    if [[ "$old" == survived ]]; then
      start=$SECONDS
      try "$file" "$line" "$column" "$size" "$instead"
      report "$number" "$operator" "$file" "$line" $((SECONDS - start))
      restore "$file"
    fi
    printf '%s\t%s\t%s\t%s\t%s\t%s\t%s\t%s\n' "$number" "$verdict" "$operator" "$file" "$line" "$column" \
      "$size" "$instead" >>"$journal"
  done 3< <(tail -n +2 "$work/journal-before.tsv")
}

prepare_journal
copy_tree
configure
baseline
if [[ "$mode" == survivors ]]; then try_survivors; else run_mutants; fi

awk -F '\t' -v at_least="$at_least" -v seed="$seed" '
  $2 == "killed" { ++killed }
  $2 == "survived" { survivors = survivors sprintf("  [%d] %s:%d  %s -> %s\n", $1, $4, $5, $3, $8) }
  $2 == "killed" || $2 == "survived" { ++all }
  $2 == "not compiled" { ++skipped }
  END {
    printf "\n%d of %d killed (seed %d; %d more did not compile)\n", killed, all, seed, skipped
    if (survivors != "") printf "survivors:\n%s", survivors
    exit 100 * killed < at_least * all
  }' "$journal"
