#!/bin/sh
# Refuses what only the objects show. (1) A weak symbol of a per-ISA object that does not carry the instruction set in its
# name: the linker keeps one copy of a weak symbol for the whole program, and if that is the AVX-512 one, older machines
# die of an illegal instruction. xsimd's own templates carry it as their architecture. Exceptions: weak_symbols.allow.
# (2) A call of libm's transcendental functions from the library, whatever overload or macro it came through.
# usage: scripts/check_symbols.sh BUILD_DIR       (tests itself first, on planted objects)
set -eu
export LC_ALL=C
allowed=$(cd "$(dirname "$0")" && pwd)/weak_symbols.allow

# Prints an offence a line for the objects (NAME_ISA.dir/*.o) and libraries (libsalvo*.a) under the folder $1.
scan() {
  for isa in scalar sse2 avx2 avx512 neon; do
    case $isa in
      avx512) tag='avx512(f|cd|dq|bw)?' ;;
      neon) tag='neon(64)?' ;;
      *) tag=$isa ;;
    esac
    find "$1" -path "*_$isa.dir/*.o" -exec nm -A -C --defined-only {} + |
      sed -n 's/:[0-9a-f]* [WVu] /: weak symbol without its instruction set: /p' |
      awk -v tag="(^|[^A-Za-z0-9_])$tag([^A-Za-z0-9_]|\$)" '
        FNR == NR { if ($0 !~ /^#|^$/) allow[++count] = "^(" $0 ")$"; next }
        {
          name = $0
          sub(/.*: weak symbol without its instruction set: /, "", name)
          if (name ~ tag) next
          for (i = 1; i <= count; ++i) if (name ~ allow[i]) next
          print
        }' "$allowed" -
  done
  libm='((a?(sin|cos|tan)h?|sincos|atan2|exp(2|10|m1)?|log(2|10|1p|b)?|pow|cbrt|hypot|fma|erfc?|[lt]gamma)[fl]?)'
  find "$1" -name 'libsalvo*.a' -exec nm -A -u {} + | sed -nE "s/: *U $libm\$/: calls libm: \1/p"
}

self_test() (
  folder=$(mktemp -d)
  trap 'rm -rf "$folder"' EXIT
  cd "$folder"
  mkdir planted_avx2.dir planted_avx512.dir
  cat >planted.cpp <<'PLANTED'
#include <cmath>
namespace xsimd { struct avx2 {}; struct avx512bw {}; }
namespace salvo { inline namespace ISA { template <class T> T tagged(T x) { return x; } } }
template <class T> T untagged(T x) { return x; }
inline namespace TAGGED_LIKE_ISA { template <class T> T impostor(T x) { return x; } }
template <class Arch> int by_architecture(int x) { return x; }
double use(double x) {
  return salvo::tagged(x) + untagged(x) + impostor(x) + by_architecture<xsimd::ARCH>(1) + std::pow(x, x);
}
PLANTED
  c++ -O0 -fno-builtin -DISA=avx2 -DARCH=avx2 -c planted.cpp -o planted_avx2.dir/a.o
  c++ -O0 -fno-builtin -DISA=avx512 -DARCH=avx512bw -c planted.cpp -o planted_avx512.dir/a.o
  c++ -O0 -fno-builtin -DISA=avx512 -DARCH=avx2 -c planted.cpp -o planted_avx512.dir/b.o
  ar rc libsalvo.a planted_avx2.dir/a.o
  cat >expected <<'EXPECTED'
./libsalvo.a:a.o: calls libm: pow
./planted_avx2.dir/a.o: double TAGGED_LIKE_ISA::impostor<double>(double)
./planted_avx2.dir/a.o: double untagged<double>(double)
./planted_avx512.dir/a.o: double TAGGED_LIKE_ISA::impostor<double>(double)
./planted_avx512.dir/a.o: double untagged<double>(double)
./planted_avx512.dir/b.o: double TAGGED_LIKE_ISA::impostor<double>(double)
./planted_avx512.dir/b.o: double untagged<double>(double)
./planted_avx512.dir/b.o: int by_architecture<xsimd::avx2>(int)
EXPECTED
  scan . | sed 's/weak symbol without its instruction set: //' | sort >found
  diff expected found >differences || {
    echo "$0 does not find what was planted (<) or finds what was not (>):"
    cat differences
    exit 1
  } >&2
)

[ -d "${1:?usage: check_symbols.sh BUILD_DIR}" ]
self_test
[ -n "$(find "$1" -path '*_scalar.dir/*.o' | head -1)" ] || { echo "no per-ISA object under $1: build first" >&2; exit 1; }
offences=$(scan "$1")
[ -z "$offences" ] || { echo "$offences"; exit 1; }
