#!/bin/bash
# Runs every fuzzer of preset asan over its seeds and then over inputs of its own: scripts/fuzz.sh [SECONDS],
# all of them together; 20 s each if not told. What they find interesting stays in the build folder, and the
# next run goes on from there.
set -euo pipefail
cd "$(dirname "$0")/.."

names=()
for source in tests/fuzz/*.cc; do names+=("$(basename "$source" .cc)"); done
total="${1:-$((20 * ${#names[@]}))}"
if [[ ! "$total" =~ ^[0-9]+$ || "$total" -lt ${#names[@]} ]]; then
  echo "$0: SECONDS is '$total', must be a whole number from ${#names[@]}, one for each fuzzer" >&2
  exit 2
fi

folder="$PWD/build/asan/tests/fuzz"
export TMPDIR="$folder" ASAN_OPTIONS=quarantine_size_mb=16 UBSAN_OPTIONS=print_stacktrace=1
failed=0
for name in "${names[@]}"; do
  corpus="$folder/corpus/$name" findings="$folder/findings/$name" log="$folder/$name.log"
  mkdir -p "$corpus" "$findings"
  if "$folder/fuzz_$name" -max_total_time=$((total / ${#names[@]})) -rss_limit_mb=512 -malloc_limit_mb=64 \
    -timeout=5 -print_funcs=0 -print_final_stats=1 -artifact_prefix="$findings/" \
    "$corpus" "tests/fuzz/seeds/$name" 2>"$log"; then
    echo "$name: $(sed -n 's/^stat::average_exec_per_sec: *//p' "$log") inputs a second, none a fault"
  else
    grep -v '^#' "$log"
    echo "$name: failed; the input is the last file in $findings" >&2
    failed=1
  fi
done
exit "$failed"
