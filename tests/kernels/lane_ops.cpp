#include "tests/kernels/lane_ops.hpp"

#include "kernels/lane.hpp"
#include "kernels/pair.hpp"

namespace salvo::tests::lane_ops {
inline namespace SALVO_ISA {

namespace {

template <class V>
V evaluate(Op op, [[maybe_unused]] V a, [[maybe_unused]] V b, [[maybe_unused]] V c) {
  switch (op) {
#define SALVO_EVALUATE(NAME, EXPRESSION, NAN_RULE) \
  case Op::NAME:                                   \
    return EXPRESSION;
    SALVO_LANE_OPS(SALVO_EVALUATE)
#undef SALVO_EVALUATE
  }
  return V(0);
}

template <class V, class T>
void apply(Op op, const T* a, const T* b, const T* c, T* out, std::size_t count) {
  for (std::size_t i = 0; i < count; i += V::width) {
    evaluate<V>(op, V::load(a + i), V::load(b + i), V::load(c + i)).store(out + i);
  }
}

template <class T>
void gather(const T* base, const std::int32_t* index, T* out, std::size_t count) {
  using V = kernels::NativeLane<T>;
  for (std::size_t i = 0; i < count; i += V::width) V::gather(base, index + i).store(out + i);
}

template <class T>
void scatter(T* base, const std::int32_t* index, const T* values, std::size_t count) {
  using V = kernels::NativeLane<T>;
  for (std::size_t i = 0; i < count; i += V::width) V::load(values + i).scatter(base, index + i);
}

template <class T>
void masks(const T* a, const T* b, std::uint32_t* bits_out, bool* any_out, bool* all_out,
           std::size_t count) {
  using V = kernels::NativeLane<T>;
  for (std::size_t i = 0; i < count; i += V::width) {
    const auto mask = V::load(a + i) < V::load(b + i);
    *bits_out++ = bits(mask);
    *any_out++ = any(mask);
    *all_out++ = all(mask);
  }
}

template <class T>
constexpr Operations<T> operations() {
  using V = kernels::NativeLane<T>;
  using Abreast = kernels::Pair<kernels::Pair<V>>;
  return {V::width, &apply<V, T>, &apply<Abreast, T>, &gather<T>, &scatter<T>, &masks<T>};
}

}  // namespace

extern const Table test_table;
const Table test_table{operations<float>(), operations<double>()};

}  // namespace SALVO_ISA
}  // namespace salvo::tests::lane_ops
