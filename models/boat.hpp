// A boat under constant thrust with resistance linear in its speed.   [Bourg & Bywalec 4.1, 7]
//
//   T - C v = m v'
#pragma once

#include <array>

#include "kernels/lane.hpp"
#include "soa/field.hpp"

namespace salvo::models {
inline namespace SALVO_ISA {

template <class V>
struct Boat {
  static constexpr bool of_positions = true;
  static constexpr std::array<soa::Field, 2> state_fields{{
      {"x", soa::Scalar::real, 1, "m", "distance", 0, -1e9, 1e9},
      {"v", soa::Scalar::real, 1, "m/s", "speed", 0, -1e9, 1e9},
  }};
  static constexpr std::array<soa::Field, 3> parameter_fields{{
      {"thrust", soa::Scalar::real, 1, "N", "T", 20000, -1e12, 1e12},
      {"resistance", soa::Scalar::real, 1, "kg/s", "C", 1000, 0, 1e12},
      {"mass", soa::Scalar::real, 1, "kg", "m", 10000, 1e-30, 1e30},
  }};
  static constexpr std::array<soa::Field, 1> result_fields{{
      {"acceleration", soa::Scalar::real, 1, "m/s^2", "of the boat", 0, -1e9, 1e9},
  }};

  std::array<V, 2> rate(V, const std::array<V, 2>& s, const std::array<V, 3>& p) const {
    return {s[1], (p[0] - p[1] * s[1]) / p[2]};
  }
  std::array<V, 1> results(const std::array<V, 5>& in, V, const std::array<V, 2>& s) const {
    return {(in[2] - in[3] * s[1]) / in[4]};
  }
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
