// A shot in moving air: uniform gravity and drag quadratic in the speed relative to the air.
// [Bourg & Bywalec 6.2]
//
//   v' = g - k |u| u,     u = v - wind,     k = 1/2 rho (Cd A)/m
#pragma once

#include <array>

#include "kernels/forces.hpp"
#include "models/event.hpp"
#include "models/flight_fields.hpp"
#include "soa/field.hpp"

namespace salvo::models {
inline namespace SALVO_ISA {

template <class V>
struct ShotInAir {
  static constexpr auto state_fields = flight_fields;
  static constexpr std::array<soa::Field, 6> parameter_fields{{
      {"drag_factor", soa::Scalar::real, 1, "1/m", "1/2 rho (Cd A)/m", 0, 0, 1e9},
      {"wind_x", soa::Scalar::real, 1, "m/s", "wind downrange", 0, -1e9, 1e9},
      {"wind_y", soa::Scalar::real, 1, "m/s", "wind up", 0, -1e9, 1e9},
      {"wind_z", soa::Scalar::real, 1, "m/s", "wind to the right", 0, -1e9, 1e9},
      {"gravity", soa::Scalar::real, 1, "m/s^2", "downward", 9.80665, -1e9, 1e9},
      {"ground", soa::Scalar::real, 1, "m", "height at which the shot ends", -1e9, -1e9, 1e9},
  }};

  std::array<V, 6> rate(V, const std::array<V, 6>& s, const std::array<V, 6>& p) const {
    const kernels::Vec3<V> velocity{s[3], s[4], s[5]};
    const kernels::Vec3<V> flow = velocity - kernels::Vec3<V>{p[1], p[2], p[3]};
    const kernels::Vec3<V> a = kernels::quadratic_drag(flow, p[0]);
    return {s[3], s[4], s[5], a.x, a.y - p[4], a.z};
  }

  static constexpr std::array<Event, 1> events{{
      {"ground", "the shot comes down to the ground", Direction::falling},
  }};
  template <class X>
  std::array<X, 1> quantities(X, const std::array<X, 6>& s, const std::array<X, 6>& p) const {
    return {s[1] - p[5]};
  }
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
