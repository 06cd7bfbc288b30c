#!/bin/bash
# Installs what is missing, builds, runs the tank experiment and says where the report is.
set -euo pipefail
cd "$(dirname "$0")"
source scripts/stage.sh

build() {
  cmake --preset release
  cmake --build --preset release --target leadline
}

leadline() {
  build/release/apps/leadline "$@"
}

one_run() {
  leadline run configs/tank_0p1.yaml --filter ukf -o results/demo-ukf --force
  leadline run configs/tank_0p1.yaml --filter ekf -o results/demo-ekf --force
  leadline report results/demo-ukf results/demo-ekf -o results/demo.html --force
}

many_runs() {
  leadline compare configs/tank_0p1.yaml configs/tank_0p3.yaml --filter ekf --filter ukf --trials 100 \
    -o results/demo-compare --force
}

stage "Install what is missing" scripts/install_dependencies.sh build
stage "Build" build
stage "One run through the tank with each filter" one_run
stage "100 runs with each filter at each speed" many_runs

printf '\nReports, for any browser:\n  %s  one run with both filters\n  %s  all runs\n' \
  "$PWD/results/demo.html" "$PWD/results/demo-compare/report.html"
