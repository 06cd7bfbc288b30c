#!/bin/bash
# Which lines of the libraries no test of theirs runs: scripts/coverage.sh [PERCENT]. Builds libraries and tests in
# build/coverage, runs them, prints the share of each library and the lines that were not run; fails if the share of
# one is below PERCENT, 95 if not told.
set -euo pipefail
cd "$(dirname "$0")/.."

least="${1:-95}"
if [[ ! "$least" =~ ^[0-9]{1,3}$ ]]; then
  echo "$0: PERCENT is '$least', must be a whole number; the share of lines that each library must reach" >&2
  exit 2
fi
scripts/install_dependencies.sh build coverage

libraries=(core vehicle submap sonar_sim)
build=build/coverage
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS="-O1 -w --coverage" \
  -DLEADLINE_BUILD_APPS=OFF -DLEADLINE_BUILD_BENCH=OFF -DLEADLINE_BUILD_TESTS=ON -DCMAKE_UNITY_BUILD=ON >/dev/null
cmake --build "$build"
find "$build" -name '*.gcda' -delete
for library in "${libraries[@]}"; do
  "$build/tests/${library}_test" --gtest_brief=1
done

# One table: file, lines, lines run, ...
filters=()
for library in "${libraries[@]}"; do filters+=(--filter "$library/"); done
gcovr --root . --object-directory "$build" "${filters[@]}" --csv "$build/lines.csv" --txt "$build/lines.txt" "$build"
sed -n '/Missing/,$p' "$build/lines.txt"
awk -F , -v least="$least" '
  FNR > 1 { split($1, folder, "/"); lines[folder[1]] += $2; run[folder[1]] += $3 }
  END {
    for (library in lines) {
      share = 100 * run[library] / lines[library]
      printf "%-10s %5.1f %% of %d lines\n", library, share, lines[library]
      if (share < least) failed = 1
    }
    if (failed) printf "a library is below %d %%\n", least
    exit failed
  }' "$build/lines.csv"
