# shellcheck shell=sh
# Sourced by the checks of source lines. A check that cannot fail is no check: before it looks at the repository it must
# find, in a folder of planted files, every line marked BAD and no other.
# The check defines plant (writes the files) and scan (prints FILE:LINE: reason), both for the current folder.

self_test() (
  folder=$(mktemp -d)
  trap 'rm -rf "$folder"' EXIT
  cd "$folder"
  plant
  grep -rn BAD . | sed 's|^\./||' | cut -d: -f1,2 | sort >expected
  scan | cut -d: -f1,2 | sort -u >found
  diff expected found >differences || {
    echo "$0 does not find what was planted (<) or finds what was not (>):"
    cat differences
    exit 1
  } >&2
)

check_lines() {
  self_test
  cd "$(dirname "$0")/.."
  offences=$(scan)
  [ -z "$offences" ] || { echo "$offences"; exit 1; }
}
