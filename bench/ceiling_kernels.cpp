#include "bench/ceiling_kernels.hpp"

#include "kernels/lane.hpp"

namespace salvo::bench {
inline namespace SALVO_ISA {

namespace {

// Touches a value and puts it back: a sign flip, the cheapest change that the compiler cannot drop.
template <class T>
void stream(const StreamColumns<T>& columns, std::size_t first, std::size_t last) {
  using V = kernels::NativeLane<T>;
  typename V::Mask odd(false);
  for (std::size_t row = first; row < last; row += V::width) {
    for (const T* column : columns.read) odd = odd | (V::load(column + row) < V(-1));
    for (T* column : columns.written) (-V::load(column + row)).store(column + row);
  }
  if (any(odd)) columns.written[0][first] = 0;
}

template <class T>
double multiply_add(std::size_t rounds) {
  using V = kernels::NativeLane<T>;
  V packs[peak_packs];
  for (std::size_t i = 0; i < peak_packs; ++i) packs[i] = V(0.1 * static_cast<double>(i));
  const V scale(0.999);
  const V offset(1e-3);
  for (std::size_t i = 0; i < rounds; ++i) {
    for (V& pack : packs) pack = pack * scale + offset;
  }
  V sum(0);
  for (const V& pack : packs) sum = sum + pack;
  alignas(64) T lanes[V::width];
  sum.store(lanes);
  return static_cast<double>(lanes[0]);
}

}  // namespace

extern const CeilingKernels ceiling_kernel_table;
const CeilingKernels ceiling_kernel_table{&stream<float>,
                                          &stream<double>,
                                          &multiply_add<float>,
                                          &multiply_add<double>,
                                          kernels::NativeLane<float>::width,
                                          kernels::NativeLane<double>::width};

}  // namespace SALVO_ISA
}  // namespace salvo::bench
