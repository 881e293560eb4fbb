#!/bin/sh
# Installs the packages that are missing, builds what has changed, runs every test and check.
# usage: ./test.sh [--quick] [--legs | --asan | --tsan] [CTEST ARGUMENTS]
#        ./test.sh --leg NAME
#   --quick  without the tests labelled slow           --legs  and the other compilers, levels and AArch64
#   --asan   the tests under address and undefined     --tsan  the tests under thread sanitizer
#   --leg    one leg alone: clang-O3 clang-O0 gcc-O0 gcc-Og aarch64
set -eu
cd "$(dirname "$0")"
preset=release
without=
legs=
while [ $# -gt 0 ]; do
  case $1 in
    --quick) without="-LE slow" ;;
    --legs) legs="-C legs" ;;
    --leg) exec scripts/legs.sh "${2:?--leg needs a name}" ;;
    --asan | --tsan) preset=${1#--} ;;
    -h | --help) sed -n '2,7s/^# //p' "$0"; exit ;;
    *) break ;;
  esac
  shift
done

scripts/setup.sh build bench test
# shellcheck disable=SC2086
set -- $without $legs "$@"
# A tree that run.sh or bench.sh set up first was told to leave these out.
benchmarks=
[ "$preset" != release ] || benchmarks=-DSALVO_BUILD_BENCHMARKS=ON
cmake --preset "$preset" -DSALVO_BUILD_TESTS=ON -DSALVO_BUILD_HASH_PROGRAM=ON $benchmarks
cmake --build "build/$preset"
# Thread sanitizer's shadow memory collides with a randomised layout on some kernels.
fixed_layout=
if [ "$preset" = tsan ] && setarch -R true 2>/dev/null; then fixed_layout="setarch -R"; fi
UBSAN_OPTIONS=print_stacktrace=1 $fixed_layout \
  ctest --test-dir "build/$preset" --output-on-failure --no-tests=error --timeout 900 -j "$(nproc)" "$@"
