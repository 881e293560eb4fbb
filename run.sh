#!/bin/sh
# Runs salvo: installs the packages that are missing, builds what has changed, hands its arguments to the command.
# usage: ./run.sh [SALVO ARGUMENTS]       default: run scenes/explosion.toml
set -eu
root=$(cd "$(dirname "$0")" && pwd)
build=$root/build/release
{
  "$root/scripts/setup.sh" build
  [ -f "$build/build.ninja" ] ||
    cmake --preset release -S "$root" -DSALVO_BUILD_TESTS=OFF -DSALVO_BUILD_BENCHMARKS=OFF
  cmake --build "$build" --target salvo_cli
} >&2
[ $# -gt 0 ] || set -- run "$root/scenes/explosion.toml"
exec "$build/cli/salvo" "$@"
