// The Sobol sequence: I. M. Sobol, "On the distribution of points in a cube", USSR Comput. Math.
// Math. Phys. 7 (1967), with the direction numbers of S. Joe and F. Y. Kuo, "Constructing Sobol
// sequences with better two-dimensional projections", SIAM J. Sci. Comput. 30 (2008), file
// new-joe-kuo-6.21201. The permutation of the Latin hypercube is a Feistel network with cycle
// walking: J. Black and P. Rogaway, "Ciphers with arbitrary finite domains" (2002).
#include "solver/sampling.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>

#include "kernels/random.hpp"
#include "solver/state_hash.hpp"

namespace salvo::solver {

namespace {

struct Direction {
  unsigned polynomial;  // its binary coefficients
  std::array<unsigned, 8> first;
};

// Of the dimensions after the first.
constexpr std::array<Direction, SampleLine::most_dimensions - 1> directions{{
    {3, {1}},
    {7, {1, 3}},
    {11, {1, 3, 1}},
    {13, {1, 1, 1}},
    {19, {1, 1, 3, 3}},
    {25, {1, 3, 5, 13}},
    {37, {1, 1, 5, 5, 17}},
    {41, {1, 1, 5, 5, 5}},
    {47, {1, 1, 7, 11, 19}},
    {55, {1, 1, 5, 1, 1}},
    {59, {1, 1, 1, 3, 11}},
    {61, {1, 3, 5, 5, 31}},
    {67, {1, 3, 3, 9, 7, 49}},
    {91, {1, 1, 1, 15, 21, 21}},
    {97, {1, 3, 1, 13, 27, 49}},
    {103, {1, 1, 1, 15, 7, 5}},
    {109, {1, 3, 1, 15, 13, 25}},
    {115, {1, 1, 5, 5, 19, 61}},
    {131, {1, 3, 7, 11, 23, 15, 103}},
    {137, {1, 3, 7, 13, 13, 15, 69}},
    {143, {1, 1, 3, 13, 7, 35, 63}},
    {145, {1, 3, 5, 9, 1, 25, 53}},
    {157, {1, 3, 1, 13, 9, 35, 107}},
    {167, {1, 3, 1, 5, 27, 61, 31}},
    {171, {1, 1, 5, 11, 19, 41, 61}},
    {185, {1, 3, 5, 3, 3, 13, 69}},
    {191, {1, 1, 7, 13, 1, 19, 1}},
    {193, {1, 3, 7, 5, 13, 19, 59}},
    {203, {1, 1, 3, 9, 25, 29, 41}},
    {211, {1, 3, 5, 13, 23, 1, 55}},
    {213, {1, 3, 7, 3, 13, 59, 17}},
    {229, {1, 3, 1, 3, 5, 53, 69}},
    {239, {1, 1, 5, 5, 23, 33, 13}},
    {241, {1, 1, 7, 7, 1, 61, 123}},
    {247, {1, 1, 7, 9, 13, 61, 49}},
    {253, {1, 3, 3, 5, 3, 55, 33}},
    {285, {1, 3, 1, 15, 31, 13, 49, 245}},
    {299, {1, 3, 5, 15, 31, 59, 63, 97}},
    {301, {1, 3, 1, 11, 11, 11, 77, 249}},
}};

constexpr int bits = 53;
constexpr int index_bits = 40;

// The numbers v_k of a dimension, as multiples of 2^-53.
void fill_directions(std::size_t dimension, std::uint64_t (&v)[index_bits]) {
  if (dimension == 0) {
    for (int k = 0; k < index_bits; ++k) v[k] = std::uint64_t{1} << (bits - 1 - k);
    return;
  }
  const Direction& direction = directions[dimension - 1];
  const int degree = std::bit_width(direction.polynomial) - 1;
  std::uint64_t m[index_bits];
  for (int k = 0; k < index_bits; ++k) {
    if (k < degree) {
      m[k] = direction.first[static_cast<std::size_t>(k)];
    } else {
      m[k] = m[k - degree] ^ (m[k - degree] << degree);
      for (int j = 1; j < degree; ++j) {
        if ((direction.polynomial >> (degree - j) & 1) != 0) m[k] ^= m[k - j] << j;
      }
    }
    v[k] = m[k] << (bits - 1 - k);
  }
}

std::uint64_t point(const std::uint64_t (&v)[index_bits], std::uint64_t index) {
  std::uint64_t gray = index ^ (index >> 1);
  std::uint64_t sum = 0;
  for (; gray != 0; gray &= gray - 1) sum ^= v[std::countr_zero(gray)];
  return sum;
}

// The middle of one of 2^53 equal parts, as near as a double comes to it.
double to_unit(std::uint64_t part) {
  return std::min((static_cast<double>(part) + 0.5) * 0x1p-53, 1 - 0x1p-53);
}

// A seed of the input's own, so that its numbers do not change with the other inputs.
std::uint64_t seed_of(std::uint64_t seed, std::string_view input) {
  std::string key(sizeof seed, '\0');
  std::memcpy(key.data(), &seed, sizeof seed);
  key += input;
  return digest_of(key.data(), key.size()).low;
}

// A draw of an id that no sample has.
constexpr std::uint64_t no_sample = ~std::uint64_t{0};

}  // namespace

std::uint64_t sobol_point(std::size_t dimension, std::uint64_t index) {
  std::uint64_t v[index_bits];
  fill_directions(dimension, v);
  return point(v, index);
}

SampleLine::SampleLine(Sampling sampling, std::uint64_t seed, std::string_view input,
                       std::size_t dimension, std::uint64_t samples)
    : sampling_(sampling), seed_(seed_of(seed, input)), samples_(samples) {
  if (sampling == Sampling::sobol) {
    fill_directions(dimension, direction_);
    shift_ = kernels::Draws(seed_, no_sample).block(0).first >> 11;
  } else if (sampling == Sampling::latin_hypercube) {
    half_bits_ = std::max(1, static_cast<int>(std::bit_width(samples - 1) + 1) / 2);
  }
}

std::uint64_t SampleLine::permuted(std::uint64_t sample) const {
  const std::uint64_t mask = (std::uint64_t{1} << half_bits_) - 1;
  std::uint64_t value = sample;
  do {
    std::uint64_t left = value >> half_bits_;
    std::uint64_t right = value & mask;
    for (std::uint32_t round = 1; round <= 6; ++round) {
      const std::uint64_t mixed = kernels::Draws(seed_, no_sample - right).block(round).first;
      const std::uint64_t next = left ^ (mixed & mask);
      left = right;
      right = next;
    }
    value = left << half_bits_ | right;
  } while (value >= samples_);
  return value;
}

double SampleLine::operator()(std::uint64_t sample) const {
  switch (sampling_) {
    case Sampling::sobol:
      return to_unit(point(direction_, sample) ^ shift_);
    case Sampling::latin_hypercube: {
      const double within = kernels::Draws(seed_, sample).uniform(0) + 0x1p-54;
      const double u =
          (static_cast<double>(permuted(sample)) + within) / static_cast<double>(samples_);
      return std::min(u, 1 - 0x1p-53);
    }
    case Sampling::random:
      break;
  }
  return to_unit(kernels::Draws(seed_, sample).block(0).first >> 11);
}

}  // namespace salvo::solver
