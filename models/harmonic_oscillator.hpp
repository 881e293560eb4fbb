// The damped harmonic oscillator, a reference problem with an exact solution: x'' + 2 d w x' + w^2
// x = 0.   [Bourg & Bywalec 13.1]
#pragma once

#include <array>

#include "kernels/lane.hpp"
#include "soa/field.hpp"

namespace salvo::models {
inline namespace SALVO_ISA {

template <class V>
struct HarmonicOscillator {
  static constexpr bool of_positions = true;
  static constexpr std::array<soa::Field, 2> state_fields{{
      {"x", soa::Scalar::real, 1, "m", "displacement", 1, -1e9, 1e9},
      {"v", soa::Scalar::real, 1, "m/s", "velocity", 0, -1e9, 1e9},
  }};
  static constexpr std::array<soa::Field, 2> parameter_fields{{
      {"frequency", soa::Scalar::real, 1, "rad/s", "undamped angular frequency w", 1, 0, 1e9},
      {"damping", soa::Scalar::real, 1, "", "damping ratio d", 0, 0, 1e9},
  }};

  std::array<V, 2> rate(V, const std::array<V, 2>& s, const std::array<V, 2>& p) const {
    const auto& [x, v] = s;
    const auto& [w, d] = p;
    return {v, -(w * (w * x + V(2) * (d * v)))};
  }
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
