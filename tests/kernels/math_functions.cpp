#include "tests/kernels/math_functions.hpp"

#include "kernels/math.hpp"

namespace salvo::tests::math_functions {
inline namespace SALVO_ISA {

namespace {

template <class V>
V evaluate(Function function, V x, V y) {
  switch (function) {
#define SALVO_EVALUATE(NAME, EXPRESSION) \
  case Function::NAME:                   \
    return EXPRESSION;
    SALVO_MATH_FUNCTIONS(SALVO_EVALUATE)
#undef SALVO_EVALUATE
  }
  return x;
}

template <class T>
void apply(Function function, const T* x, const T* y, T* out, std::size_t count) {
  using V = kernels::NativeLane<T>;
  for (std::size_t i = 0; i < count; i += V::width) {
    evaluate<V>(function, V::load(x + i), V::load(y + i)).store(out + i);
  }
}

}  // namespace

extern const Table test_table;
const Table test_table{{&apply<float>}, {&apply<double>}};

}  // namespace SALVO_ISA
}  // namespace salvo::tests::math_functions
