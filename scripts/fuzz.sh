#!/bin/bash
# Runs every fuzzer of preset fuzz over its seeds and then over inputs of its own: scripts/fuzz.sh [SECONDS],
# all of them together; 20 s each if not told. What they find interesting stays in the build folder, and the
# next run goes on from there.
set -euo pipefail
cd "$(dirname "$0")/.."

names=()
for source in tests/fuzz/*.cc; do names+=("$(basename "$source" .cc)"); done
seconds=$((${1:-20 * ${#names[@]}} / ${#names[@]}))

folder="$PWD/build/fuzz/tests/fuzz"
export TMPDIR="$folder" ASAN_OPTIONS=quarantine_size_mb=16 UBSAN_OPTIONS=print_stacktrace=1
failed=()
for name in "${names[@]}"; do
  corpus="$folder/corpus/$name" findings="$folder/findings/$name" log="$folder/$name.log"
  mkdir -p "$corpus" "$findings"
  if "$folder/fuzz_$name" -max_total_time="$seconds" -rss_limit_mb=512 -malloc_limit_mb=64 -timeout=5 \
    -print_final_stats=1 -artifact_prefix="$findings/" "$corpus" "tests/fuzz/seeds/$name" 2>"$log"; then
    echo "$name: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") inputs in $seconds s"
  else
    failed+=("$name")
    grep -v '^#' "$log"
  fi
done

for name in "${failed[@]}"; do
  echo "$name failed; the input is the last file of:" >&2
  ls -tr "$folder/findings/$name"/* >&2
done
[[ ${#failed[@]} -eq 0 ]]
