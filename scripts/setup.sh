#!/bin/sh
# Installs the Debian 12 packages that are missing, as root or through sudo; without either, prints the exact apt line and
# stops. Instant when nothing is missing.
# usage: scripts/setup.sh GROUP...     groups: build bench peers test clang arm64
# shellcheck disable=SC2086,SC2116
set -eu

# One list a group; the design says what each is for. python3-vtk9 cannot be installed beside python3-paraview.
build="cmake ninja-build g++ libxsimd-dev libsleef-dev libtbb-dev libxxhash-dev libtomlplusplus-dev libfmt-dev
  libeigen3-dev librandom123-dev libhdf5-dev zlib1g-dev libcli11-dev nlohmann-json3-dev"
bench="libbenchmark-dev libboost-dev python3"
# What the benchmarks are compared with and no test needs: libsundials-dev brings over a hundred packages, MPI and PETSc among
# them, and LAMMPS needs little more.
peers="libsundials-dev liblammps-dev"
test="libboost-dev libgtest-dev librapidcheck-dev libmpfr-dev clang-format-14 clang-tidy-14
  python3 python3-numpy python3-h5py python3-vtk9 python3-pandas python3-xarray python3-h5netcdf python3-netcdf4"
clang="clang"
# Only this group adds a foreign architecture. HDF5 is not in it: its two architectures exclude each other.
arm64="g++-aarch64-linux-gnu qemu-user libxsimd-dev:arm64 libsleef-dev:arm64 libtbb-dev:arm64 libxxhash-dev:arm64
  libtomlplusplus-dev:arm64 libfmt-dev:arm64"

wanted=
foreign=
for group; do
  case $group in
    build) wanted="$wanted $build" ;;
    bench) wanted="$wanted $bench" ;;
    peers) wanted="$wanted $peers" ;;
    test) wanted="$wanted $test" ;;
    clang) wanted="$wanted $clang" ;;
    arm64) wanted="$wanted $arm64"; foreign=arm64 ;;
    *) echo "setup.sh: unknown group \"$group\": build, bench, peers, test, clang or arm64" >&2; exit 2 ;;
  esac
done

# dpkg-query fails when it does not know a package: that, too, is an answer.
installed=" $(dpkg-query -W -f '${db:Status-Status} ${Package} ${Package}:${Architecture}\n' $wanted 2>/dev/null |
  sed -n 's/^installed //p' | tr '\n' ' ') "
missing=
for package in $wanted; do
  case $installed$missing in
    *" $package "*) ;;
    *) missing="$missing $package " ;;
  esac
done
[ -n "$missing" ] || exit 0
missing=$(echo $missing)

if [ "$(id -u)" = 0 ]; then
  as_root=
elif command -v sudo >/dev/null && { sudo -n true 2>/dev/null || { [ -t 0 ] && sudo true; }; }; then
  as_root=sudo
else
  echo "These Debian packages are missing and need root to install. Run this as root, then try again:" >&2
  echo "  ${foreign:+dpkg --add-architecture $foreign && }apt-get update &&" \
    "apt-get install --no-install-recommends $missing" >&2
  exit 1
fi

echo "Installing: $missing" >&2
log=$(mktemp)
trap 'rm -f "$log"' EXIT
{
  [ -z "$foreign" ] || $as_root dpkg --add-architecture "$foreign"
  # An unreachable third-party list must not stop us: the install below says what it could not find.
  $as_root apt-get update -q || true
  # --no-remove: rather fail than take away what somebody else installed.
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends --no-remove $missing
} >"$log" 2>&1 || {
  cat "$log" >&2
  echo "setup.sh: apt-get failed, see above" >&2
  exit 1
}
