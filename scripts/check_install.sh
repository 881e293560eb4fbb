#!/bin/sh
# Installs a finished build into an empty prefix, moves the prefix, and builds and runs tests/consumer against it: what is
# installed is complete, points neither into this repository nor to where it was installed first, and needs nothing else.
# usage: scripts/check_install.sh BUILD_DIR
set -eu
build=$(cd "${1:?usage: check_install.sh BUILD_DIR}" && pwd)
root=$(cd "$(dirname "$0")/.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

cmake --install "$build" --prefix "$folder/first" >/dev/null
if grep -rlF -e "$root" -e "$folder" "$folder/first" --include='*.cmake' --include='*.hpp'; then
  echo "the installed files above name a folder of this machine" >&2
  exit 1
fi
mv "$folder/first" "$folder/prefix"
cmake -S "$root/tests/consumer" -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_PREFIX_PATH="$folder/prefix" >/dev/null
cmake --build "$folder/build"
"$folder/build/consumer"
