// What the machine could do at most: read-modify-write of a particle's columns without arithmetic,
// and multiply-add without memory.
#pragma once

#include <cstddef>

#include "solver/isa.hpp"

namespace salvo::bench {

/// The columns that the free particles step: six read and written, two read.
template <class T>
struct StreamColumns {
  T* written[6];
  const T* read[2];
};

/// Independent packs of the multiply-add peak: enough to hide the latency of both operations on two
/// units each, few enough for sixteen registers.
inline constexpr std::size_t peak_packs = 12;

struct CeilingKernels {
  void (*stream_float32)(const StreamColumns<float>&, std::size_t first, std::size_t last);
  void (*stream_float64)(const StreamColumns<double>&, std::size_t first, std::size_t last);
  /// `rounds` rounds of one multiply and one add in each of `peak_packs` packs.
  double (*multiply_add_float32)(std::size_t rounds);
  double (*multiply_add_float64)(std::size_t rounds);
  std::size_t width_float32;
  std::size_t width_float64;
};

const CeilingKernels& ceiling_kernels(solver::Isa isa);

}  // namespace salvo::bench
