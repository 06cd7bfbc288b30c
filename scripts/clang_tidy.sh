#!/bin/bash
# Runs clang-tidy over the sources, last changed first, until all are checked or the time is used up:
# scripts/clang_tidy.sh [SECONDS]. It needs the release build; warnings (-w) are that build's affair.
set -euo pipefail
cd "$(dirname "$0")/.."

deadline=$(($(date +%s) + ${1:-150}))
export deadline

check() {
  if [[ $(date +%s) -ge $deadline ]]; then
    echo "$1: not checked, the time is used up"
    return
  fi
  local output
  if ! output="$(clang-tidy -p build/release --quiet --extra-arg=-w "$1" 2>&1)"; then
    printf '%s:\n%s\n' "$1" "$output"
    return 1
  fi
}
export -f check

{
  git diff --name-only HEAD
  git log --format= --name-only
} | awk '/^(core|vehicle|submap|sonar_sim|apps|bench)\/.*\.cc$/ && !seen[$0]++' |
  while read -r file; do [[ ! -f "$file" ]] || echo "$file"; done |
  xargs -r -n 1 -P "$(nproc)" bash -c 'check "$1"' _
