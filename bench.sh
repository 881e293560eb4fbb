#!/bin/sh
# Builds and runs every benchmark and prints one table; FILE gets Google Benchmark's JSON, with the results of all programs
# in one "benchmarks" list.
# usage: ./bench.sh [--quick] [--json FILE]       --quick ends within 5 minutes and holds every row
set -eu
root=$(cd "$(dirname "$0")" && pwd)
build=$root/build/release
json=
min_time=0.5
while [ $# -gt 0 ]; do
  case $1 in
    --quick) min_time=0.05; export SALVO_BENCH_QUICK=1 ;;
    --json) json=${2:?--json needs a file}; shift ;;
    *) sed -n '2,4s/^# //p' "$0" >&2; exit 2 ;;
  esac
  shift
done

{
  "$root/scripts/setup.sh" build bench
  "$root/scripts/setup.sh" peers || echo "bench.sh: without SUNDIALS and LAMMPS, which are compared with" >&2
  # Only a fresh build tree leaves the tests out: one that has them keeps them.
  [ -f "$build/build.ninja" ] || set -- -DSALVO_BUILD_TESTS=OFF
  cmake --preset release -S "$root" -DSALVO_BUILD_BENCHMARKS=ON "$@"
  cmake --build "$build" --target bench/all
} >&2

results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
for program in "$build"/bench/salvo_bench*; do
  [ -f "$program" ] || continue  # no match
  name=$(basename "$program")
  echo "== $name" >&2
  "$program" --benchmark_min_time="$min_time" --benchmark_out_format=json --benchmark_out="$results/$name.json" >&2
done
/usr/bin/python3 "$root/scripts/merge_benchmarks.py" "$results" ${json:+"$json"}
