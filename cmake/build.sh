#!/usr/bin/env bash
# Configures and builds one preset of CMakePresets.json; quiet unless something is new or wrong.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=$1
shift
directory=build
[ "$preset" = release ] || directory=build/$preset
/usr/bin/cmake --preset "$preset" --log-level=WARNING >/dev/null
ninja -C "$directory" -j "${GLENOID_JOBS:-2}" --quiet "$@"
