#!/bin/sh
# The other compilers, optimisation levels and processor family: each leg builds scene/ and the rooms below it with the
# hash program, and runs the shipped scenes against the golden hashes that the release build was checked with.
# usage: scripts/legs.sh LEG...     legs: clang-O3 clang-O0 gcc-O0 gcc-Og aarch64 (all: every one)
set -eu
cd "$(dirname "$0")/.."

leg() {
  case $1 in
    clang-O3) groups="build clang"; set -- "$1" -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_CXX_FLAGS=-O3 ;;
    clang-O0) groups="build clang"; set -- "$1" -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_CXX_FLAGS=-O0 ;;
    gcc-O0) groups=build; set -- "$1" -DCMAKE_CXX_COMPILER=g++ -DCMAKE_CXX_FLAGS=-O0 -DSALVO_ENABLE_AVX512=OFF ;;
    gcc-Og) groups=build; set -- "$1" -DCMAKE_CXX_COMPILER=g++ -DCMAKE_CXX_FLAGS=-Og ;;
    aarch64) groups="build arm64"; set -- "$1" -DCMAKE_TOOLCHAIN_FILE=cmake/aarch64-linux-gnu.cmake -DCMAKE_CXX_FLAGS=-O2 ;;
    *) echo "legs.sh: unknown leg \"$1\": clang-O3, clang-O0, gcc-O0, gcc-Og, aarch64 or all" >&2; exit 2 ;;
  esac
  echo "== $1"
  build=build/legs/$1
  shift
  # shellcheck disable=SC2086
  scripts/setup.sh $groups
  # The build type None adds no flag of its own: the leg's level, with assertions.
  cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=None "$@" -DSALVO_BUILD_RECORDING=OFF \
    -DSALVO_BUILD_BENCHMARKS=OFF -DSALVO_BUILD_TESTS=OFF -DSALVO_BUILD_HASH_PROGRAM=ON -DSALVO_FLATTEN_KERNELS=OFF
  cmake --build "$build" --target salvo_hashes
  emulator=$(sed -n 's/^CMAKE_CROSSCOMPILING_EMULATOR:[A-Z]*=//p' "$build/CMakeCache.txt" | tr ';' ' ')
  program=$(find "$build" -name salvo_hashes -type f)
  # shellcheck disable=SC2086
  $emulator "$program" --check tests/golden/hashes.txt scenes/*.toml scenes/*/*.toml
}

[ $# -gt 0 ] || { sed -n '2,4s/^# //p' "$0" >&2; exit 2; }
[ "$1" != all ] || set -- clang-O3 clang-O0 gcc-O0 gcc-Og aarch64
for name; do
  (leg "$name")
done
