#!/bin/sh
# Refuses, in the rooms whose results are bits, every operation that can give other bits on another instruction set,
# compiler, C library, thread count or run, and in the build files the flags that do. A line that is safe for a reason of
# its own says so at its end:  // exact-set: the reason
# usage: scripts/check_exact_set.sh       (tests itself first, on planted lines)
set -eu
. "$(dirname "$0")/planted.sh"
rooms="kernels integrators models soa solver scene recording"

# Prints FILE:LINE: reason for every offence under the current folder.
scan() {
  # shellcheck disable=SC2016,SC2086
  find $rooms CMakeLists.txt CMakePresets.json cmake \( -name '*.hpp' -o -name '*.cpp' -o -name CMakeLists.txt \
    -o -name '*.cmake' -o -name CMakePresets.json \) -type f 2>/dev/null | sort | xargs awk '
    function ban(pattern, reason) { patterns[++bans] = "(^|[^A-Za-z0-9_])(" pattern ")"; reasons[bans] = reason }

    # The line without comments and without what stands inside quotes. A comment may span lines.
    function code_of(line,    code, token) {
      gsub(/\047\\?"\047/, "0", line)  # a quoted quote
      while (line != "") {
        if (in_comment) {
          if (!match(line, /\*\//)) return code
          in_comment = 0
          line = substr(line, RSTART + 2)
        }
        if (!match(line, /\/\/|\/\*|"/)) return code line
        token = substr(line, RSTART, RLENGTH)
        code = code substr(line, 1, RSTART - 1) " "
        line = substr(line, RSTART + RLENGTH)
        if (token == "//") return code
        if (token == "/*") in_comment = 1
        else if (match(line, /^([^"\\]|\\.)*"/)) line = substr(line, RLENGTH + 1)
      }
      return code
    }

    BEGIN {
      libm = "(a?(sin|cos|tan)h?|atan2|exp[2m]?1?|exp10|log(2|10|1p|b)?|pow|cbrt|hypot|fma|fmod|remainder|remquo|fdim" \
             "|fmin|fmax|lerp|erfc?|[lt]gamma)"
      ban("std::" libm "[fl]?[^A-Za-z0-9_]", "libm differs between C libraries: use kernels/math.hpp")
      ban("(__builtin_)?" libm "[fl][ ]*[(]", "libm differs between C libraries: use kernels/math.hpp")
      ban("__builtin_" libm "[ ]*[(]", "libm differs between C libraries: use kernels/math.hpp")
      ban("std::sqrt|__builtin_sqrt", "only kernels/lane.hpp takes square roots of plain numbers: use a lane")
      allow[bans] = "kernels/lane.hpp"
      ban("xsimd::", "only kernels/lane.hpp names xsimd: use Lane")
      allow[bans] = "kernels/lane.hpp"
      ban("xsimd::(fn?m[as]|sincos|exp[a-z0-9]*|log[a-z0-9]*|a?(sin|cos|tan)h?|atan2|pow|cbrt|hypot|fmod|remainder|erfc?" \
          "|[lt]gamma|min|max|nearbyint|rint)[^A-Za-z0-9_]", "fuses, branches on all lanes, or differs between widths")
      ban("(xsimd::)?(rsqrt|reciprocal|hadd|haddp)[ ]*[(]", "an approximation or a cross-lane sum")
      ban("xsimd::reduce|_mm[0-9]*_(mask_)?reduce_|vaddvq?_f|_mm[0-9]*_hadd", "a cross-lane sum depends on the width")
      ban("_mm[0-9]*_(maskz?_|mask3_)?fn?m(add|sub)|vfm[as]q?_", "a fused multiply-add has other bits")
      ban("_mm[0-9]*_(maskz?_)?(rsqrt|rcp)|vrsqrt|vrecp", "an approximation differs between processors")
      ban("std::[a-z_]+_distribution|std::(shuffle|sample|generate_canonical)[^a-z_]",
          "differs between standard libraries: use kernels/random.hpp")
      ban("random_device|s?rand[ ]*[(]", "not the same on every run: use kernels/random.hpp")
      ban("std::unordered_|std::hash[^a-z_]", "hash order is not part of a result: use a sorted vector or std::map")
      ban("std::(sort|partial_sort|nth_element|ranges::sort)[^a-z_]",
          "orders ties as it likes: use std::stable_sort, or say why no two keys are equal")
      ban("std::(transform_)?reduce[^a-z_]|std::execution::|parallel_(deterministic_)?reduce|parallel_scan",
          "sums in no fixed order: use solver/reduction")
      ban("static_partitioner", "splits by the number of threads")
      ban("atomic(_ref)?<[ ]*(float|double|Real|T)[ ]*>", "a floating-point atomic sums in the order of arrival")
      ban("optimize[ ]*[(]|pragma (GCC|clang) (optimize|fp)|STDC (FP_CONTRACT|FENV_ACCESS)|float_control",
          "changes the arithmetic of one function behind the flags of the build")
      code_bans = bans
      # Flags, in the files that set them.
      ban("-(ffast-math|Ofast|f(unsafe|finite|associative|reciprocal)-math[a-z-]*|ffp-contract=(fast|on)|mrecip[a-z=]*" \
          "|mfma|march=native|mtune=native)", "a flag that changes bits")
    }
    FNR == 1 { in_comment = 0; is_code = FILENAME ~ /[.][hc]pp$/ }
    /\/\/ exact-set: [^ ]/ { next }
    {
      line = $0
      if (is_code) line = code_of(line)
      else if (FILENAME !~ /json$/) sub(/#.*/, "", line)
      first = is_code ? 1 : code_bans + 1
      last = is_code ? code_bans : bans
      for (i = first; i <= last; ++i)
        if (line ~ patterns[i] && allow[i] != FILENAME) print FILENAME ":" FNR ": " reasons[i]
    }' /dev/null
}

plant() {
  mkdir kernels solver cmake
  cat >kernels/planted.hpp <<'PLANTED'
a = std::sin(x);  // BAD
a = std::powf(x, y);  // BAD
a = sinf(x);  // BAD
a = sin(x);
a = std::single(x); a = std::floor(x); a = std::atan_table;
a = std::sqrt(x);  // BAD
/* std::cos(x)
   std::cos(x) */ a = std::cos(x);  // BAD
const char* s = "std::cos(x) // "; a = std::exp(x);  // BAD
const char* s = "-ffast-math std::cos(x) \" std::cos(x)";
// std::log(x); xsimd::fma(a, b, c)
a = std::tan(x);  // exact-set: printed only
a = std::tan(x);  /* BAD */  // exact-set:
a = xsimd::load(p);  // BAD
a = rsqrt(x);  // BAD
a = hadd(x);  // BAD
a = reciprocal(x);  // BAD
a = _mm512_reduce_add_ps(x);  // BAD
a = _mm256_fmadd_ps(x, y, z);  // BAD
a = _mm_rsqrt_ps(x);  // BAD
a = _mm512_sqrt_ps(x);
std::normal_distribution<double> d;  // BAD
std::mt19937 g(std::random_device{}());  // BAD
std::unordered_map<int, int> m;  // BAD
std::map<int, int> m;
std::sort(a, b);  // BAD
std::stable_sort(a, b);
std::reduce(a, b);  // BAD
tbb::static_partitioner p;  // BAD
std::atomic<double> x;  // BAD
std::atomic<std::size_t> x;
__attribute__((optimize("fast-math")))  // BAD
#pragma GCC optimize ("O3")  // BAD
#error "not with -ffast-math"
PLANTED
  cat >kernels/lane.hpp <<'PLANTED'
a = std::sqrt(x); a = xsimd::select(m, x, y);
a = xsimd::fma(x, y, z);  // BAD
a = xsimd::sincos(x);  // BAD
a = xsimd::reduce_add(x);  // BAD
PLANTED
  cat >cmake/Planted.cmake <<'PLANTED'
add_compile_options(-fno-fast-math)  # never -ffast-math
add_compile_options(-O3 -ffast-math)  # BAD
add_compile_options("-march=native")  # BAD
PLANTED
}

check_lines
