// Counter-based random numbers: Philox4x32-10 (Salmon et al. 2011) of (seed, id, draw). A draw is a
// pure function of its key, so order, threads, batches and resumption cannot change it.
// Distributions are ours, over kernels/math, because the standard library's differ between
// implementations.
#pragma once

#include <Random123/philox.h>

#include <cstdint>

#include "kernels/math.hpp"
#include "kernels/vec3.hpp"

namespace salvo::kernels {
inline namespace SALVO_ISA {

/// The draws of one id. Each draw number gives 128 independent bits; a distribution says how many
/// draws it takes.
class Draws {
 public:
  using S = ScalarLane<double>;

  Draws(std::uint64_t seed, std::uint64_t id) : seed_(seed), id_(id) {}

  /// Uniform on [0, 1), multiples of 2^-53. One draw.
  double uniform(std::uint32_t draw) const { return to_unit(block(draw).first); }
  /// Uniform on [low, high], high by rounding only. One draw.
  double uniform(std::uint32_t draw, double low, double high) const {
    return low + (high - low) * uniform(draw);
  }
  /// Uniform whole number of [low, high], both included. One draw; biased by less than (high - low)
  /// 2^-53.
  std::int64_t integer(std::uint32_t draw, std::int64_t low, std::int64_t high) const {
    const S count(static_cast<double>(high - low + 1));
    return low + static_cast<std::int64_t>(floor(S(uniform(draw)) * count).value());
  }
  /// Standard normal, by Box and Muller. One draw.
  double normal(std::uint32_t draw) const {
    const auto [first, second] = block(draw);
    const double u = to_unit(first) + 0x1p-54;  // never zero, so that the logarithm is finite
    return (sqrt(S(-2) * log(S(u))) * cos(S(2 * pi * to_unit(second)))).value();
  }
  /// Normal with the given mean and width, truncated to [low, high] by rejection. Draws `draw`,
  /// `draw` + stride, ..: the caller keeps them free. After 1000 rejections (an interval of
  /// probability under 1 %) a uniform value of the interval.
  double truncated_normal(std::uint32_t draw, std::uint32_t stride, double mean, double width,
                          double low, double high) const {
    for (std::uint32_t attempt = 0; attempt < 1000; ++attempt) {
      const double value = mean + width * normal(draw + attempt * stride);
      if (low <= value && value <= high) return value;
    }
    return uniform(draw, low, high);
  }
  /// Uniform on the unit sphere. One draw.
  Vec3<double> on_sphere(std::uint32_t draw) const {
    const auto [first, second] = block(draw);
    return around_y(S(1 - 2 * to_unit(first)), second);
  }
  /// Uniform on the cap of the unit sphere within `half_angle` (rad) of the unit vector `axis`. One
  /// draw.
  Vec3<double> in_cone(std::uint32_t draw, Vec3<double> axis, double half_angle) const {
    const auto [first, second] = block(draw);
    const S cosine = S(1) - S(to_unit(first)) * (S(1) - cos(S(half_angle)));
    const Vec3<double> d = around_y(cosine, second);
    // Turn y onto the axis by the shortest rotation. An axis that points down is reached in the
    // mirror: straight onto it the rotation has no direction at -y and loses digits near it.
    const double side = axis.y < 0 ? -1 : 1;
    const double up = axis.y * side;
    const double along = d.x * axis.x + d.z * axis.z;
    const double k = d.y - along / (1 + up);
    return {d.x + axis.x * k, (d.y * up - along) * side, d.z + axis.z * k};
  }

  struct Block {
    std::uint64_t first, second;
  };
  /// The 128 bits of a draw.
  Block block(std::uint32_t draw) const {
    r123::Philox4x32 philox;
    const r123::Philox4x32::ctr_type counter = {
        {static_cast<std::uint32_t>(id_), static_cast<std::uint32_t>(id_ >> 32), draw, 0}};
    const r123::Philox4x32::key_type key = {
        {static_cast<std::uint32_t>(seed_), static_cast<std::uint32_t>(seed_ >> 32)}};
    const auto out = philox(counter, key);
    return {out[0] | std::uint64_t{out[1]} << 32, out[2] | std::uint64_t{out[3]} << 32};
  }

 private:
  static double to_unit(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }
  // The unit vector whose angle from y has this cosine, at an azimuth drawn from `bits`.
  static Vec3<double> around_y(S cosine, std::uint64_t bits) {
    const S sine = sqrt(max(S(1) - cosine * cosine, S(0)));
    const S azimuth(2 * pi * to_unit(bits));
    return {(sine * cos(azimuth)).value(), cosine.value(), (sine * sin(azimuth)).value()};
  }

  std::uint64_t seed_;
  std::uint64_t id_;
};

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
