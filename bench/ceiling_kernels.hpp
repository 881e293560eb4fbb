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

struct CeilingKernels {
  void (*stream_single)(const StreamColumns<float>&, std::size_t first, std::size_t last);
  void (*stream_twice)(const StreamColumns<double>&, std::size_t first, std::size_t last);
  /// `rounds` rounds of one multiply and one add in 8 independent packs; returns lanes x 16 x
  /// rounds flops' result.
  double (*multiply_add_single)(std::size_t rounds);
  double (*multiply_add_twice)(std::size_t rounds);
  std::size_t width_single;
  std::size_t width_twice;
};

const CeilingKernels& ceiling_kernels(solver::Isa isa);

}  // namespace salvo::bench
