// The cannon of Bourg & Bywalec: a shell with drag linear in its speed and a push by the wind that
// does not depend on it, from the mouth of a barrel, at a box.   [2.5, 4.2, 18.1]
//
//   m v' = -c v + c_w wind - m g,     x(0) = base + length direction
#pragma once

#include <array>

#include "kernels/lane.hpp"
#include "models/event.hpp"
#include "models/flight.hpp"
#include "soa/field.hpp"

namespace salvo::models {
inline namespace SALVO_ISA {

template <class V>
struct Cannon {
  static constexpr auto state_fields = flight_fields;
  static constexpr bool of_positions = true;
  static constexpr std::array<soa::Field, 3> force_fields{{
      {"drag_rate", soa::Scalar::real, 1, "1/s", "c/m", 0, 0, 1e9},
      {"push_x", soa::Scalar::real, 1, "m/s^2", "c_w wind/m downrange", 0, -1e9, 1e9},
      {"push_z", soa::Scalar::real, 1, "m/s^2", "c_w wind/m to the right", 0, -1e9, 1e9},
  }};
  static constexpr std::array<soa::Field, 8> shared_fields{{
      {"gravity", soa::Scalar::real, 1, "m/s^2", "downward", 9.80665, -1e9, 1e9},
      {"ground", soa::Scalar::real, 1, "m", "height at which the shell ends", -1e9, -1e9, 1e9},
      {"target_x", soa::Scalar::real, 1, "m", "middle of the box", 0, -1e9, 1e9},
      {"target_y", soa::Scalar::real, 1, "m", "middle of the box", 0, -1e9, 1e9},
      {"target_z", soa::Scalar::real, 1, "m", "middle of the box", 0, -1e9, 1e9},
      {"half_x", soa::Scalar::real, 1, "m", "half its edge; 0: there is no box", 0, 0, 1e9},
      {"half_y", soa::Scalar::real, 1, "m", "half its edge", 0, 0, 1e9},
      {"half_z", soa::Scalar::real, 1, "m", "half its edge", 0, 0, 1e9},
  }};
  static constexpr auto parameter_fields = force_fields + shared_fields;
  static constexpr std::array<soa::Field, 6> further_inputs{{
      {"barrel", soa::Scalar::real, 1, "m", "its length, from the start to the mouth", 0, 0, 1e9},
      {"mass", soa::Scalar::real, 1, "kg", "of the shell", 1, 1e-30, 1e30},
      {"linear_drag", soa::Scalar::real, 1, "kg/s", "c", 0, 0, 1e9},
      {"wind_drag", soa::Scalar::real, 1, "kg/s", "c_w", 0, 0, 1e9},
      {"wind_x", soa::Scalar::real, 1, "m/s", "wind downrange", 0, -1e9, 1e9},
      {"wind_z", soa::Scalar::real, 1, "m/s", "wind to the right", 0, -1e9, 1e9},
  }};
  static constexpr auto input_fields = launch_fields + shared_fields + further_inputs;
  static constexpr auto result_fields = flight_result_fields;

  std::array<V, 17> start(const std::array<V, 20>& in) const {
    const kernels::Vec3<V> direction = launch_velocity(V(1), in[4], in[5]);
    const V barrel = in[14];
    const V mass = in[15];
    const V push = in[17] / mass;
    return {in[0] + barrel * direction.x,
            in[1] + barrel * direction.y,
            in[2] + barrel * direction.z,
            in[3] * direction.x,
            in[3] * direction.y,
            in[3] * direction.z,
            in[16] / mass,
            push * in[18],
            push * in[19],
            in[6],
            in[7],
            in[8],
            in[9],
            in[10],
            in[11],
            in[12],
            in[13]};
  }
  std::array<V, 3> results(const std::array<V, 20>& in, V, const std::array<V, 6>& s) const {
    return flight_results(in[15], s);
  }

  std::array<V, 6> rate(V, const std::array<V, 6>& s, const std::array<V, 11>& p) const {
    return {s[3], s[4], s[5], p[1] - p[0] * s[3], -(p[0] * s[4] + p[3]), p[2] - p[0] * s[5]};
  }

  // The shell enters the box through a face while it is within the other two pairs.
  static constexpr std::array<Event, 8> events{{
      {"ground", "the shell comes down to the ground", Direction::falling, true},
      {"target_front", "it enters the box through the face of least x", Direction::rising, true},
      {"target_back", "it enters the box through the opposite face", Direction::falling, true},
      {"target_bottom", "it enters the box through the face of least y", Direction::rising, true},
      {"target_top", "it enters the box through the opposite face", Direction::falling, true},
      {"target_left", "it enters the box through the face of least z", Direction::rising, true},
      {"target_right", "it enters the box through the opposite face", Direction::falling, true},
      {"apex", "it is at its highest", Direction::falling, false},
  }};
  template <class X>
  X quantity(std::size_t event, X, const std::array<X, 6>& s, const std::array<X, 11>& p) const {
    if (event == 0) return s[1] - p[4];
    if (event == 7) return s[4];
    const std::size_t axis = (event - 1) / 2;
    const X from_middle = s[axis] - p[5 + axis];
    return event % 2 == 1 ? from_middle + p[8 + axis] : from_middle - p[8 + axis];
  }
  typename V::Mask accepts(std::size_t event, const std::array<V, 6>& s,
                           const std::array<V, 11>& p) const {
    if (event == 0 || event == 7) return typename V::Mask(true);
    typename V::Mask within = p[8] > V(0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis == (event - 1) / 2) continue;
      within = within & (abs(s[axis] - p[5 + axis]) <= p[8 + axis]);
    }
    return within;
  }
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
