// A shot in moving air: uniform gravity and drag quadratic in the speed relative to the air.
// [Bourg & Bywalec 6.2]
//
//   v' = g - k |u| u,     u = v - wind,     k = 1/2 rho (Cd A)/m
#pragma once

#include <array>

#include "kernels/forces.hpp"
#include "models/event.hpp"
#include "models/flight.hpp"
#include "soa/field.hpp"

namespace salvo::models {
inline namespace SALVO_ISA {

template <class V>
struct ShotInAir {
  static constexpr auto state_fields = flight_fields;
  static constexpr bool of_positions = true;
  static constexpr std::array<soa::Field, 7> parameter_fields{{
      {"drag_factor", soa::Scalar::real, 1, "1/m", "1/2 rho (Cd A)/m", 0, 0, 1e9},
      {"wind_x", soa::Scalar::real, 1, "m/s", "wind downrange", 0, -1e9, 1e9},
      {"wind_y", soa::Scalar::real, 1, "m/s", "wind up", 0, -1e9, 1e9},
      {"wind_z", soa::Scalar::real, 1, "m/s", "wind to the right", 0, -1e9, 1e9},
      {"gravity", soa::Scalar::real, 1, "m/s^2", "downward", 9.80665, -1e9, 1e9},
      {"ground", soa::Scalar::real, 1, "m", "height at which the shot ends", -1e9, -1e9, 1e9},
      {"range", soa::Scalar::real, 1, "m", "distance downrange at which it ends", 1e9, -1e9, 1e9},
  }};
  static constexpr std::array<soa::Field, 1> mass_field{{
      {"mass", soa::Scalar::real, 1, "kg", "for the energy alone", 1, 1e-30, 1e30},
  }};
  static constexpr auto input_fields = launch_fields + parameter_fields + mass_field;
  static constexpr auto result_fields = flight_result_fields;

  std::array<V, 6> rate(V, const std::array<V, 6>& s, const std::array<V, 7>& p) const {
    const kernels::Vec3<V> velocity{s[3], s[4], s[5]};
    const kernels::Vec3<V> flow = velocity - kernels::Vec3<V>{p[1], p[2], p[3]};
    const kernels::Vec3<V> a = kernels::quadratic_drag(flow, p[0]);
    return {s[3], s[4], s[5], a.x, a.y - p[4], a.z};
  }

  std::array<V, 13> start(const std::array<V, 14>& in) const {
    const kernels::Vec3<V> v = launch_velocity(in[3], in[4], in[5]);
    return {in[0], in[1], in[2], v.x, v.y, v.z, in[6], in[7], in[8], in[9], in[10], in[11], in[12]};
  }
  std::array<V, 3> results(const std::array<V, 14>& in, V, const std::array<V, 6>& s) const {
    return flight_results(in[13], s);
  }

  static constexpr std::array<Event, 3> events{{
      {"ground", "the shot comes down to the ground", Direction::falling, true},
      {"range", "it reaches the range", Direction::rising, true},
      {"apex", "it is at its highest", Direction::falling, false},
  }};
  template <class X>
  X quantity(std::size_t event, X, const std::array<X, 6>& s, const std::array<X, 7>& p) const {
    switch (event) {
      case 0:
        return s[1] - p[5];
      case 1:
        return s[0] - p[6];
      default:
        return s[4];
    }
  }
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
