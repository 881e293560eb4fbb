// Seeded hills for height fields: a sum of eight plane waves of random direction and phase.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace salvo::scene {

struct Hills {
  std::size_t columns = 0;  ///< samples along x
  std::size_t rows = 0;     ///< samples along z
  double deviation = 0;     ///< standard deviation of the heights, m
  double length = 0;        ///< longest wavelength, m; the others go down to 4/11 of it
  std::uint64_t seed = 0;
};

/// Heights row by row, in m: that of sample (i, j) at j columns + i, x = i spacing, z = j spacing.
std::vector<double> hill_heights(const Hills& hills, double spacing);

}  // namespace salvo::scene
