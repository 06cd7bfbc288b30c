#!/bin/bash
# Runs every fuzzer of preset fuzz over its seeds and then on inputs of its own: scripts/fuzz.sh [SECONDS],
# 20 s each unless told how many all of them have together. What they found interesting is kept in the build
# folder, and gone on from the next time.
set -euo pipefail
cd "$(dirname "$0")/.."

folder="${LEADLINE_FUZZ_BUILD:-build/fuzz}/tests/fuzz"
shopt -s nullglob
fuzzers=()
for source in tests/fuzz/*.cc; do fuzzers+=("$(basename "$source" .cc)"); done
seconds=$((${1:-20 * ${#fuzzers[@]}} / ${#fuzzers[@]}))

mkdir -p "$folder/tmp"
export TMPDIR="$PWD/$folder/tmp" ASAN_OPTIONS=quarantine_size_mb=16 UBSAN_OPTIONS=print_stacktrace=1
failed=()
for name in "${fuzzers[@]}"; do
  findings="$folder/findings/$name" corpus="$folder/corpus/$name"
  mkdir -p "$findings" "$corpus"
  if "$folder/fuzz_$name" -max_total_time="$seconds" -rss_limit_mb=512 -malloc_limit_mb=64 -timeout=5 -verbosity=0 \
    -print_final_stats=1 -artifact_prefix="$findings/" "$corpus" "tests/fuzz/seeds/$name" 2>"$folder/$name.log"; then
    printf '%-10s %s s, %s inputs\n' "$name" "$seconds" \
      "$(sed -n 's/^stat::number_of_executed_units: *//p' "$folder/$name.log")"
  else
    failed+=("$name")
    cat "$folder/$name.log"
  fi
done

for name in "${failed[@]}"; do
  echo "$name failed; $folder/fuzz_$name FILE repeats it:" "$folder/findings/$name"/* >&2
done
[[ ${#failed[@]} -eq 0 ]]
