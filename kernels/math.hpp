// Transcendental functions over lanes, from SLEEF's cinz family: no fused multiply-add, the same
// bits on SSE2, AVX, AVX-512, Advanced SIMD and plain C. The only source of transcendental values
// on any path that reaches state or results: libm differs between C libraries.
//
// Errors are at most 1.0 ulp over the whole range (asserted against MPFR in
// tests/kernels/math_test.cpp), but for results of atan2 near and below the smallest normal number
// (1.5 ulp) and for overflow to infinity a little early: sinh and cosh (beyond 88.7228 in float,
// 709.7827 in double), exp (beyond 709.78271114 in double), log1p (beyond 1e38 in float, 1e307 in
// double).
//
// They are calls, not inlined: an AVX-512 pack of doubles costs about 10 ns in exp, 17 in log, 18
// in sin, 59 in pow.
#pragma once

// First, because SLEEF includes the compiler's intrinsics, too: the lane's header does it with the
// warnings off that gcc 12 has about its own.
#include "kernels/lane.hpp"

#include <sleef.h>

namespace salvo::kernels {
inline namespace SALVO_ISA {

/// Circle constant, rounded to double.
inline constexpr double pi = 3.14159265358979323846;

// A declaration of FUNCTION(x) for float and double on one instruction set, and a plain name for
// each.
#define SALVO_MATH_1(NAME, ISA, FLOAT, DOUBLE, GET)               \
  inline Lane<float, ISA> NAME(Lane<float, ISA> x) {              \
    return Lane<float, ISA>(Sleef_cinz_##NAME##FLOAT(x.GET()));   \
  }                                                               \
  inline Lane<double, ISA> NAME(Lane<double, ISA> x) {            \
    return Lane<double, ISA>(Sleef_cinz_##NAME##DOUBLE(x.GET())); \
  }
#define SALVO_MATH_2(NAME, ISA, FLOAT, DOUBLE, GET)                         \
  inline Lane<float, ISA> NAME(Lane<float, ISA> x, Lane<float, ISA> y) {    \
    return Lane<float, ISA>(Sleef_cinz_##NAME##FLOAT(x.GET(), y.GET()));    \
  }                                                                         \
  inline Lane<double, ISA> NAME(Lane<double, ISA> x, Lane<double, ISA> y) { \
    return Lane<double, ISA>(Sleef_cinz_##NAME##DOUBLE(x.GET(), y.GET()));  \
  }
#define SALVO_MATH(ISA, FLOAT, DOUBLE, GET)    \
  SALVO_MATH_1(sin, ISA, FLOAT, DOUBLE, GET)   \
  SALVO_MATH_1(cos, ISA, FLOAT, DOUBLE, GET)   \
  SALVO_MATH_1(tan, ISA, FLOAT, DOUBLE, GET)   \
  SALVO_MATH_1(asin, ISA, FLOAT, DOUBLE, GET)  \
  SALVO_MATH_1(acos, ISA, FLOAT, DOUBLE, GET)  \
  SALVO_MATH_1(atan, ISA, FLOAT, DOUBLE, GET)  \
  SALVO_MATH_1(sinh, ISA, FLOAT, DOUBLE, GET)  \
  SALVO_MATH_1(cosh, ISA, FLOAT, DOUBLE, GET)  \
  SALVO_MATH_1(tanh, ISA, FLOAT, DOUBLE, GET)  \
  SALVO_MATH_1(exp, ISA, FLOAT, DOUBLE, GET)   \
  SALVO_MATH_1(expm1, ISA, FLOAT, DOUBLE, GET) \
  SALVO_MATH_1(log, ISA, FLOAT, DOUBLE, GET)   \
  SALVO_MATH_1(log1p, ISA, FLOAT, DOUBLE, GET) \
  SALVO_MATH_1(log10, ISA, FLOAT, DOUBLE, GET) \
  SALVO_MATH_1(cbrt, ISA, FLOAT, DOUBLE, GET)  \
  SALVO_MATH_2(pow, ISA, FLOAT, DOUBLE, GET)   \
  SALVO_MATH_2(atan2, ISA, FLOAT, DOUBLE, GET)

SALVO_MATH(Scalar, f1_u10purec, d1_u10purec, value)
#if defined(SALVO_ISA_sse2)
SALVO_MATH(Sse2, f4_u10sse2, d2_u10sse2, batch)
#elif defined(SALVO_ISA_avx2)
SALVO_MATH(Avx2, f8_u10avx, d4_u10avx, batch)
#elif defined(SALVO_ISA_avx512)
SALVO_MATH(Avx512, f16_u10avx512fnofma, d8_u10avx512fnofma, batch)
#elif defined(SALVO_ISA_neon)
SALVO_MATH(Neon, f4_u10advsimdnofma, d2_u10advsimdnofma, batch)
#endif
#undef SALVO_MATH
#undef SALVO_MATH_2
#undef SALVO_MATH_1

/// x to the whole power n >= 0 by repeated multiplication, in a fixed order.
template <class V>
V power(V x, int n) {
  V result(1);
  for (int i = 0; i < n; ++i) result = result * x;
  return result;
}

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
