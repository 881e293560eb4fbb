// A projectile with a standard drag function in the standard atmosphere: a point mass whose drag
// follows the Mach number at every stage of a step.
//
//   v' = -(pi/8) rho(h) Cd(|u|/c(h)) |u| u / BC - g(h) - 2 Omega x v,     u = v - wind
#pragma once

#include <array>

#include "kernels/dual.hpp"
#include "kernels/forces.hpp"
#include "models/cubic_place.hpp"
#include "models/event.hpp"
#include "models/flight.hpp"
#include "models/projectile_tables.hpp"
#include "models/standard_atmosphere.hpp"
#include "soa/field.hpp"

namespace salvo::models {
inline namespace SALVO_ISA {

template <class V>
struct Projectile {
  using T = typename V::Real;
  using Data = DragTables;

  Projectile() : tables(projectile_tables<T>()) {}
  explicit Projectile(const DragTables& data) : tables(data.of<T>()) {}

  static constexpr auto state_fields = flight_fields;
  static constexpr bool of_positions = true;
  static constexpr std::array<soa::Field, 1> coefficient_field{{
      {"ballistic_coefficient", soa::Scalar::real, 1, "kg/m^2", "m/(i d^2)", 150, 1e-9, 1e9},
  }};
  static constexpr std::array<soa::Field, 1> factor_field{{
      {"drag_factor", soa::Scalar::real, 1, "m^2/kg", "pi/8 over the ballistic coefficient",
       kernels::pi / 8 / 150, 0, 1e9},
  }};
  static constexpr std::array<soa::Field, 11> shared_fields{{
      {"drag_function", soa::Scalar::real, 1, "", "index in models::drag_functions; 7: an own one",
       4, 0, 7},
      {"wind_x", soa::Scalar::real, 1, "m/s", "wind downrange", 0, -1e9, 1e9},
      {"wind_y", soa::Scalar::real, 1, "m/s", "wind up", 0, -1e9, 1e9},
      {"wind_z", soa::Scalar::real, 1, "m/s", "wind to the right", 0, -1e9, 1e9},
      {"wind_exponent", soa::Scalar::real, 1, "",
       "the wind goes with y/wind_height to this power, none below y = 0; 0: the same everywhere",
       0, 0, 10},
      {"wind_height", soa::Scalar::real, 1, "m", "y of the given wind", 10, 1e-9, 1e9},
      {"gravity", soa::Scalar::real, 1, "m/s^2", "downward, at y = 0", 9.80665, -1e9, 1e9},
      {"gravity_falloff", soa::Scalar::real, 1, "1/m",
       "f of gravity/(1 + f y)^2; one over the radius of the Earth", 0, 0, 1},
      {"altitude", soa::Scalar::real, 1, "m", "of y = 0 above the sea", 0, -5000, 80000},
      {"ground", soa::Scalar::real, 1, "m", "y at which it comes down", -1e9, -1e9, 1e9},
      {"range", soa::Scalar::real, 1, "m", "distance downrange at which it ends", 1e9, -1e9, 1e9},
  }};
  static constexpr std::array<soa::Field, 3> rotation_fields{{
      {"rotation_x", soa::Scalar::real, 1, "rad/s", "of the Earth about x", 0, -1, 1},
      {"rotation_y", soa::Scalar::real, 1, "rad/s", "about y", 0, -1, 1},
      {"rotation_z", soa::Scalar::real, 1, "rad/s", "about z", 0, -1, 1},
  }};
  static constexpr auto parameter_fields = factor_field + shared_fields + rotation_fields;
  static constexpr std::array<soa::Field, 4> further_inputs{{
      {"mass", soa::Scalar::real, 1, "kg", "for the energy alone", 1, 1e-30, 1e30},
      {"earth_rotation", soa::Scalar::real, 1, "rad/s", "7.292115e-5 for the Coriolis force", 0, -1,
       1},
      {"latitude", soa::Scalar::real, 1, "rad", "of the place, north is positive", 0, -1.6, 1.6},
      {"bearing", soa::Scalar::real, 1, "rad", "of x, clockwise from north", 0, -7, 7},
  }};
  static constexpr auto input_fields =
      launch_fields + coefficient_field + shared_fields + further_inputs;
  static constexpr auto result_fields = flight_result_fields;

  std::array<V, 21> start(const std::array<V, 22>& in) const {
    const kernels::Vec3<V> v = launch_velocity(in[3], in[4], in[5]);
    std::array<V, 21> out;
    for (std::size_t i = 0; i < 3; ++i) out[i] = in[i];
    out[3] = v.x;
    out[4] = v.y;
    out[5] = v.z;
    out[6] = V(kernels::pi / 8) / in[6];
    for (std::size_t i = 7; i < 18; ++i) out[i] = in[i];
    const V north = in[19] * cos(in[20]);
    out[18] = north * cos(in[21]);
    out[19] = in[19] * sin(in[20]);
    out[20] = -(north * sin(in[21]));
    return out;
  }
  std::array<V, 3> results(const std::array<V, 22>& in, V, const std::array<V, 6>& s) const {
    return flight_results(in[18], s);
  }

  // Out of line: as a part of every stage of every method it would take minutes to compile.
  [[gnu::noinline]] std::array<V, 6> rate(V, const std::array<V, 6>& s,
                                          const std::array<V, 15>& p) const {
    const kernels::Vec3<V> velocity{s[3], s[4], s[5]};
    const kernels::Vec3<V> flow = velocity - wind(s[1], p);
    const CubicPlace<V> place(tables.density, geopotential(s[1] + p[9]));
    const V density = place.value(tables.density.coefficients());
    const V slowness = place.value(tables.slowness.coefficients());

    const V speed = norm(flow);
    CubicPlace<V> mach(tables.drag_place, speed * slowness);
    mach.shift(p[1] * V(static_cast<T>(tables.drag_stride)));
    const V cd = mach.value(tables.drag.coefficients());
    const kernels::Vec3<V> drag = flow * -(density * cd * speed * p[0]);
    const kernels::Vec3<V> coriolis = cross(velocity, kernels::Vec3<V>{p[12], p[13], p[14]}) * V(2);
    return {s[3],
            s[4],
            s[5],
            drag.x + coriolis.x,
            drag.y + coriolis.y - gravity(s[1], p),
            drag.z + coriolis.z};
  }

  static constexpr std::array<Event, 4> events{{
      {"ground", "it comes down to the ground", Direction::falling, true},
      {"range", "it reaches the range", Direction::rising, true},
      {"apex", "it is at its highest", Direction::falling, false},
      {"mach_1", "it becomes slower than sound", Direction::falling, false},
  }};
  template <class X>
  X quantity(std::size_t event, X, const std::array<X, 6>& s, const std::array<X, 15>& p) const {
    switch (event) {
      case 0:
        return s[1] - p[10];
      case 1:
        return s[0] - p[11];
      case 2:
        return s[4];
      default: {
        const kernels::Vec3<X> flow = kernels::Vec3<X>{s[3], s[4], s[5]} - wind(s[1], p);
        return norm(flow) * slowness(s[1] + p[9]) - X(1);
      }
    }
  }

 private:
  template <class X>
  static X geopotential(X height) {
    const X radius(atmosphere_radius);
    return radius * height / (radius + height);
  }

  // One over the speed of sound.
  V slowness(V height) const {
    return CubicPlace<V>(tables.density, geopotential(height))
        .value(tables.slowness.coefficients());
  }
  kernels::Dual<V> slowness(kernels::Dual<V> height) const {
    const kernels::Dual<V> at = geopotential(height);
    const CubicPlace<V> place(tables.density, at.value);
    return {place.value(tables.slowness.coefficients()), place.slope(tables.slowness) * at.rate};
  }

  static V gravity(V y, const std::array<V, 15>& p) {
    // Divided by one exactly where it does not fall off, whether or not another lane divides.
    if (!any(p[8] != V(0))) return p[7];
    const V nearer = V(1) + p[8] * y;
    return p[7] / (nearer * nearer);
  }

  static kernels::Vec3<V> wind(V y, const std::array<V, 15>& p) {
    const kernels::Vec3<V> given{p[2], p[3], p[4]};
    const auto sheared = p[5] != V(0);
    // One for a wind that is the same everywhere, whether or not another lane takes the power.
    if (!any(sheared)) return given;
    return given * select(sheared, pow(max(y, V(0)) / p[6], p[5]), V(1));
  }
  static kernels::Vec3<kernels::Dual<V>> wind(kernels::Dual<V> y,
                                              const std::array<kernels::Dual<V>, 15>& p) {
    const kernels::Vec3<kernels::Dual<V>> given{p[2], p[3], p[4]};
    const auto sheared = p[5].value != V(0);
    if (!any(sheared)) return given;
    const V part = pow(max(y.value, V(0)) / p[6].value, p[5].value);
    const V slope = select(y.value > V(0), part * p[5].value * y.rate / y.value, V(0));
    return given * kernels::Dual<V>(select(sheared, part, V(1)), select(sheared, slope, V(0)));
  }

  const ProjectileTables<T>& tables;
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
