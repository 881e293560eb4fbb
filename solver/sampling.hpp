// Where in their distributions the random inputs of a sweep are: a number between 0 and 1 for each
// input and sample, a function of the seed, the input's name and the sample's index alone.
#pragma once

#include <cstdint>
#include <string_view>

namespace salvo::solver {

enum class Sampling {
  random,           ///< independent numbers
  latin_hypercube,  ///< one number in each of N equal parts, for every input
  sobol             ///< a low-discrepancy sequence, shifted by the seed
};

/// One input's numbers.
class SampleLine {
 public:
  /// Inputs that the Sobol sequence has dimensions for.
  static constexpr std::size_t most_dimensions = 40;

  /// `input` names the input; `dimension` is its place in the model's list, which the Sobol
  /// sequence goes by; `samples` is the N of a Latin hypercube.
  SampleLine(Sampling sampling, std::uint64_t seed, std::string_view input, std::size_t dimension,
             std::uint64_t samples);

  /// Above 0 and below 1; `sample` below 2^40.
  double operator()(std::uint64_t sample) const;

 private:
  std::uint64_t permuted(std::uint64_t sample) const;

  Sampling sampling_;
  std::uint64_t seed_;
  std::uint64_t samples_;
  int half_bits_ = 0;
  std::uint64_t shift_ = 0;
  std::uint64_t direction_[40] = {};
};

/// Point `index` of a dimension of the Sobol sequence, as a multiple of 2^-53, in the order of Gray
/// codes; point 0 is 0.
std::uint64_t sobol_point(std::size_t dimension, std::uint64_t index);

}  // namespace salvo::solver
