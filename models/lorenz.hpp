// The Lorenz equations, a reference problem for integrators: x' = s (y - x), y' = x (r - z) - y,
// z' = x y - b z.   [E. N. Lorenz, "Deterministic nonperiodic flow", J. Atmos. Sci. 20 (1963)]
#pragma once

#include <array>

#include "kernels/lane.hpp"
#include "soa/field.hpp"

namespace salvo::models {
inline namespace SALVO_ISA {

template <class V>
struct Lorenz {
  static constexpr std::array<soa::Field, 3> state_fields{{
      {"x", soa::Scalar::real, 1, "", "rate of the convection", 1, -1e9, 1e9},
      {"y", soa::Scalar::real, 1, "", "difference of temperature across", 0, -1e9, 1e9},
      {"z", soa::Scalar::real, 1, "", "distortion of the temperature profile", 0, -1e9, 1e9},
  }};
  static constexpr std::array<soa::Field, 3> parameter_fields{{
      {"sigma", soa::Scalar::real, 1, "", "Prandtl number", 10, 0, 1e9},
      {"rho", soa::Scalar::real, 1, "", "Rayleigh number over its critical value", 28, 0, 1e9},
      {"beta", soa::Scalar::real, 1, "", "shape of the rolls", 8.0 / 3, 0, 1e9},
  }};

  std::array<V, 3> rate(V, const std::array<V, 3>& s, const std::array<V, 3>& p) const {
    const auto& [x, y, z] = s;
    const auto& [sigma, rho, beta] = p;
    return {sigma * (y - x), x * (rho - z) - y, x * y - beta * z};
  }
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
