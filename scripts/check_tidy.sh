#!/bin/sh
# Runs clang-tidy 14 (.clang-tidy) on the library's baseline sources: the per-ISA ones are the same headers again.
# Looks only when a source has changed since it last found nothing.
# usage: scripts/check_tidy.sh BUILD_DIR
set -eu
build=$(cd "${1:?usage: check_tidy.sh BUILD_DIR}" && pwd)
cd "$(dirname "$0")/.."
clean=$build/tidy.clean
rooms="soa kernels integrators models solver scene recording cli"

# shellcheck disable=SC2086
[ ! -f "$clean" ] ||
  [ -n "$(find .clang-tidy CMakeLists.txt cmake $rooms -type f -newer "$clean" 2>/dev/null | head -1)" ] || exit 0
touch "$clean.started"
# Sources that salvo_add_kernels compiles are listed once an instruction set.
# shellcheck disable=SC2086
find $rooms -name '*.cpp' 2>/dev/null | sort | while read -r source; do
  [ "$(grep -c "\"file\": \".*/$source\"" "$build/compile_commands.json")" != 1 ] || echo "$source"
done | xargs -n 1 -P "$(nproc)" clang-tidy-14 --quiet -p "$build" --extra-arg=-Wno-unknown-warning-option \
  2>"$build/tidy.log" || { grep -v 'warnings\{0,1\} generated' "$build/tidy.log" >&2; exit 1; }
mv "$clean.started" "$clean"
