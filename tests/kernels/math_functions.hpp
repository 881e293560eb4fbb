// Every function of kernels/math.hpp behind plain function pointers, for each instruction set.
// Arrays are 64-byte aligned and their length is a multiple of 64.
#pragma once

#include <cstddef>

namespace salvo::tests::math_functions {

// X(name, expression in V x, y)
#define SALVO_MATH_FUNCTIONS(X) \
  X(sin, sin(x))                \
  X(cos, cos(x))                \
  X(tan, tan(x))                \
  X(asin, asin(x))              \
  X(acos, acos(x))              \
  X(atan, atan(x))              \
  X(sinh, sinh(x))              \
  X(cosh, cosh(x))              \
  X(tanh, tanh(x))              \
  X(exp, exp(x))                \
  X(expm1, expm1(x))            \
  X(log, log(x))                \
  X(log1p, log1p(x))            \
  X(log10, log10(x))            \
  X(cbrt, cbrt(x))              \
  X(pow, pow(x, y))             \
  X(atan2, atan2(x, y))

enum class Function {
#define SALVO_ENUMERATOR(NAME, EXPRESSION) NAME,
  SALVO_MATH_FUNCTIONS(SALVO_ENUMERATOR)
#undef SALVO_ENUMERATOR
};

template <class T>
struct Operations {
  /// out[i] = function(x[i], y[i])
  void (*apply)(Function function, const T* x, const T* y, T* out, std::size_t count);
};

struct Table {
  Operations<float> single;
  Operations<double> twice;
};

}  // namespace salvo::tests::math_functions
