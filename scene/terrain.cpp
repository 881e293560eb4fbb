#include "scene/terrain.hpp"

#include "kernels/random.hpp"
#include "soa/id.hpp"

namespace salvo::scene {

std::vector<double> hill_heights(const Hills& hills, double spacing) {
  using S = kernels::ScalarLane<double>;
  constexpr int waves = 8;
  // Serials of the stream that no emitter may take, far from those of the gusts.
  constexpr std::uint64_t first_serial = 1 << 20;
  std::vector<double> heights(hills.columns * hills.rows);
  for (int w = 0; w < waves; ++w) {
    const kernels::Draws draws(hills.seed, soa::make_id(soa::max_stream, first_serial + w));
    const S bearing(2 * kernels::pi * draws.uniform(0));
    const double phase = 2 * kernels::pi * draws.uniform(1);
    const double number = 2 * kernels::pi / hills.length * (1 + 0.25 * w);
    const double along_x = number * cos(bearing).value();
    const double along_z = number * sin(bearing).value();
    // Eight waves of this amplitude have the variance deviation^2.
    const double amplitude = hills.deviation / 2;
    for (std::size_t j = 0; j < hills.rows; ++j) {
      for (std::size_t i = 0; i < hills.columns; ++i) {
        const double x = static_cast<double>(i) * spacing;
        const double z = static_cast<double>(j) * spacing;
        heights[j * hills.columns + i] +=
            amplitude * sin(S(along_x * x + along_z * z + phase)).value();
      }
    }
  }
  return heights;
}

}  // namespace salvo::scene
