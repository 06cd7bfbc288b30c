#!/bin/bash
# Installs what is missing, builds and runs the tests. Tests on public recordings run when
# LEADLINE_DATA names the folder that holds them.
set -euo pipefail
cd "$(dirname "$0")"
source scripts/stage.sh

build() {
  cmake --preset release
  cmake --build --preset release
}

stage "Install what is missing" scripts/install_dependencies.sh build
stage "Build" build
stage "Test" ctest --preset release -j "$(nproc)"
