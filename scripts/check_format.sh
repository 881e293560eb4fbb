#!/bin/sh
# Checks our C++ against .clang-format with clang-format 14, the version that the file is written for.
# usage: scripts/check_format.sh [--fix]
set -eu
cd "$(dirname "$0")/.."
case ${1-} in
  --fix) mode=-i ;;
  "") mode="--dry-run -Werror" ;;
  *) echo "usage: scripts/check_format.sh [--fix]" >&2; exit 2 ;;
esac
# shellcheck disable=SC2086
find soa kernels integrators models solver scene recording cli python bench tests \
  \( -name '*.hpp' -o -name '*.cpp' \) 2>/dev/null | sort | xargs clang-format-14 $mode
