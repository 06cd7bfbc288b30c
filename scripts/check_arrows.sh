#!/bin/bash
# No include against the arrows of the architecture. CMake gives every room the include paths of those it may
# use and no others; this check needs no build, and names the line that is at fault.
set -euo pipefail
cd "$(dirname "$0")/.."

git grep -nE '^#include "(apps|leadline)/' -- core vehicle submap sonar_sim apps | awk -F '[:"]' '
  BEGIN {
    low = "core vehicle submap support "
    may["core"] = ""
    may["vehicle"] = "core"
    may["submap"] = "core vehicle"
    may["sonar_sim"] = "core vehicle"
    may["support"] = "core"
    may["wire"] = low
    may["keys"] = low
    may["config"] = low "sonar_sim keys"
    may["recordings"] = low "wire"
    may["maps"] = low "wire recordings"
    may["evaluation"] = low "sonar_sim wire keys config recordings"
    may["node"] = may["evaluation"] " maps"
    may["results"] = may["node"] " evaluation node"
    may["report"] = may["results"] " results"
    may["cli"] = may["report"] " report"
  }
  function room(path) {
    sub(/^(apps|leadline)\//, "", path)
    sub(/\/.*/, "", path)
    return path
  }
  {
    from = room($1)
    to = room($4)
    if (from == to || index(" " may[from] " ", " " to " ")) next
    printf "%s:%d: %s must not include \"%s\"; it may use: %s\n", $1, $2, from, $4, may[from]
    failed = 1
  }
  END { exit failed }' >&2
