#!/bin/bash
# Replays the small recordings of tests/replay and compares what the estimator makes of them, to nine digits.
#   scripts/replay.sh            compare
#   scripts/replay.sh --update   write what it makes of them now; the difference is for the reviewer to read
#   scripts/replay.sh --record   simulate the recordings anew as well
set -euo pipefail
cd "$(dirname "$0")/.."

case "${1:-}" in
  "") ;;
  --update) export LEADLINE_REPLAY=update ;;
  --record) export LEADLINE_REPLAY=record ;;
  *) echo "$0: unknown argument '$1'; allowed: --update, --record" >&2; exit 2 ;;
esac

cmake --preset release >/dev/null
cmake --build --preset release --target replay_test
build/release/tests/replay_test --gtest_brief=1
[[ -z "${LEADLINE_REPLAY:-}" ]] || git --no-pager diff --stat -- tests/replay
