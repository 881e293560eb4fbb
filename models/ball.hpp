// A sphere that spins in moving air: drag, with or without the drag crisis, and Magnus lift.
// [Bourg & Bywalec 6.2, 6.3]
//
//   m v' = -1/2 rho A Cd |u| u + 1/2 rho A CL |u| (n x u) + k rho r^3 w (n x u) - m g
//   w' = -w/tau,     u = v - wind,     n the axis of the spin
//
// With a viscosity the drag coefficient is that of a smooth sphere at the Reynolds number Re = |u|
// 2 r/nu, from Stokes' to past the drag crisis:
//
//   Cd = 24/Re + 2.6 (Re/5)/(1 + (Re/5)^1.52) + 0.411 R^0.06/(1 + R^8) + 0.25 Q/(1 + Q),
//   R = Re/2.63e5,     Q = Re/1e6
//
// [F. A. Morrison, "An Introduction to Fluid Mechanics", Cambridge (2013), figure 8.13]
#pragma once

#include <array>

#include "kernels/forces.hpp"
#include "models/event.hpp"
#include "models/flight.hpp"
#include "soa/field.hpp"

namespace salvo::models {
inline namespace SALVO_ISA {

/// Cd |u| of a smooth sphere in m/s, which is finite at rest; `scale` is 2 r/nu in s/m.
template <class V>
V sphere_drag_speed(V speed, V scale) {
  const V re = speed * scale;
  const V viscous = V(24) / scale;
  const V fifth = re / V(5);
  const V crisis = re / V(2.63e5);
  const V square = crisis * crisis;
  const V fourth = square * square;
  const V high = re / V(1e6);
  const V rest = V(2.6) * fifth / (V(1) + pow(fifth, V(1.52))) +
                 V(0.411) * pow(crisis, V(0.06)) / (V(1) + fourth * fourth) +
                 V(0.25) * high / (V(1) + high);
  return viscous + speed * rest;
}

template <class V>
struct Ball {
  static constexpr std::array<soa::Field, 1> spin_field{{
      {"spin", soa::Scalar::real, 1, "rad/s", "backspin about +z lifts", 0, -1e6, 1e6},
  }};
  static constexpr auto state_fields = flight_fields + spin_field;
  static constexpr std::array<soa::Field, 5> force_fields{{
      {"area", soa::Scalar::real, 1, "m^2/kg", "1/2 rho A/m, per metre of air", 0, 0, 1e9},
      {"reynolds", soa::Scalar::real, 1, "s/m", "2 r/nu; 0: the drag coefficient is constant", 0, 0,
       1e12},
      {"magnus", soa::Scalar::real, 1, "", "k rho r^3/m", 0, -1e9, 1e9},
      {"decay", soa::Scalar::real, 1, "1/s", "1/tau", 0, 0, 1e9},
      {"drag", soa::Scalar::real, 1, "", "Cd", 0, 0, 1e9},
  }};
  static constexpr std::array<soa::Field, 10> shared_fields{{
      {"lift_coefficient", soa::Scalar::real, 1, "", "CL", 0, -1e3, 1e3},
      {"axis_x", soa::Scalar::real, 1, "", "n, of unit length", 0, -1, 1},
      {"axis_y", soa::Scalar::real, 1, "", "n", 0, -1, 1},
      {"axis_z", soa::Scalar::real, 1, "", "n", 1, -1, 1},
      {"wind_x", soa::Scalar::real, 1, "m/s", "wind downrange", 0, -1e9, 1e9},
      {"wind_y", soa::Scalar::real, 1, "m/s", "wind up", 0, -1e9, 1e9},
      {"wind_z", soa::Scalar::real, 1, "m/s", "wind to the right", 0, -1e9, 1e9},
      {"gravity", soa::Scalar::real, 1, "m/s^2", "downward", 9.80665, -1e9, 1e9},
      {"ground", soa::Scalar::real, 1, "m", "height at which the ball ends", -1e9, -1e9, 1e9},
      {"range", soa::Scalar::real, 1, "m", "distance downrange at which it ends", 1e9, -1e9, 1e9},
  }};
  static constexpr auto parameter_fields = force_fields + shared_fields;
  static constexpr std::array<soa::Field, 7> further_inputs{{
      {"mass", soa::Scalar::real, 1, "kg", "m", 0.145, 1e-30, 1e30},
      {"radius", soa::Scalar::real, 1, "m", "r", 0.0366, 1e-9, 1e9},
      {"air_density", soa::Scalar::real, 1, "kg/m^3", "rho", 1.225, 0, 1e9},
      {"drag_coefficient", soa::Scalar::real, 1, "", "Cd, where there is no viscosity", 0.5, 0,
       1e3},
      {"viscosity", soa::Scalar::real, 1, "m^2/s", "nu, 1.48e-5 of air; 0: Cd is constant", 0, 0,
       1e9},
      {"magnus_factor", soa::Scalar::real, 1, "",
       "k: pi for a smooth sphere in slow flow, pi^2 in the book's program", 0, -100, 100},
      {"spin_decay", soa::Scalar::real, 1, "1/s", "1/tau", 0, 0, 1e9},
  }};
  static constexpr auto input_fields = launch_fields + spin_field + shared_fields + further_inputs;
  static constexpr auto result_fields = flight_result_fields;

  std::array<V, 22> start(const std::array<V, 24>& in) const {
    const kernels::Vec3<V> v = launch_velocity(in[3], in[4], in[5]);
    const V mass = in[17];
    const V radius = in[18];
    const V density = in[19];
    std::array<V, 22> out{in[0], in[1], in[2], v.x, v.y, v.z, in[6]};
    out[7] = V(0.5 * kernels::pi) * density * radius * radius / mass;
    out[8] = select(in[21] > V(0), V(2) * radius / in[21], V(0));
    out[9] = in[22] * density * radius * radius * radius / mass;
    out[10] = in[23];
    out[11] = in[20];
    for (std::size_t i = 0; i < 10; ++i) out[12 + i] = in[7 + i];
    return out;
  }
  std::array<V, 3> results(const std::array<V, 24>& in, V, const std::array<V, 7>& s) const {
    return flight_results(in[17], {s[0], s[1], s[2], s[3], s[4], s[5]});
  }

  std::array<V, 7> rate(V, const std::array<V, 7>& s, const std::array<V, 15>& p) const {
    using Vec = kernels::Vec3<V>;
    const Vec flow = Vec{s[3], s[4], s[5]} - Vec{p[9], p[10], p[11]};
    const V speed = norm(flow);
    const Vec lift = cross(Vec{p[6], p[7], p[8]}, flow) * (p[0] * p[5] * speed + p[2] * s[6]);
    const Vec drag = flow * -(p[0] * drag_speed(speed, p));
    return {s[3],          s[4], s[5], drag.x + lift.x, drag.y + lift.y - p[12], drag.z + lift.z,
            -(p[3] * s[6])};
  }

  static constexpr std::array<Event, 3> events{{
      {"ground", "the ball comes down to the ground", Direction::falling, true},
      {"range", "it reaches the range", Direction::rising, true},
      {"apex", "it is at its highest", Direction::falling, false},
  }};
  template <class X>
  X quantity(std::size_t event, X, const std::array<X, 7>& s, const std::array<X, 15>& p) const {
    switch (event) {
      case 0:
        return s[1] - p[13];
      case 1:
        return s[0] - p[14];
      default:
        return s[4];
    }
  }

 private:
  static V drag_speed(V speed, const std::array<V, 15>& p) {
    const V constant = p[4] * speed;
    const auto viscous = p[1] > V(0);
    // The same value whether or not another lane has a viscosity.
    if (!any(viscous)) return constant;
    return select(viscous, sphere_drag_speed(speed, select(viscous, p[1], V(1))), constant);
  }
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
