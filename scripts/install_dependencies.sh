#!/bin/bash
# Installs the Debian packages that are missing: scripts/install_dependencies.sh build|check|coverage...
#   build     what the presets build with: the libraries, the command, the tests, the benchmarks
#   check     what .ci/run needs besides
#   coverage  what scripts/coverage.sh needs besides
set -euo pipefail

build=(
  cmake g++ iproute2 ninja-build
  libboost-dev libeigen3-dev
  libcli11-dev libfmt-dev liblcm-bin liblcm-dev libmatio-dev libspdlog-dev libsystemd-dev
  libyaml-cpp-dev
  node-d3 nlohmann-json3-dev
  libbenchmark-dev libgmock-dev libgtest-dev
)
check=(chromium clang clang-format clang-tidy doxygen git libclang-rt-dev)
coverage=(gcovr)

missing=()
for group in "$@"; do
  case "$group" in
    build | check | coverage) ;;
    *) echo "$0: unknown group '$group'; allowed: build, check, coverage" >&2; exit 2 ;;
  esac
  declare -n packages="$group"
  for package in "${packages[@]}"; do
    [[ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" == installed ]] || missing+=("$package")
  done
done
[[ ${#missing[@]} -gt 0 ]] || exit 0

as_root=()
if [[ $EUID -ne 0 ]]; then
  if ! command -v sudo >/dev/null; then
    echo "$0: neither root nor sudo; install these packages and start again: ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi

echo "Installing ${missing[*]}"
apt_get=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0)
"${apt_get[@]}" update
"${apt_get[@]}" install --yes --no-install-recommends "${missing[@]}" >/dev/null
