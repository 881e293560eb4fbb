// The forces on one particle, as accelerations in m/s^2 unless named otherwise. Each is the formula
// of the book's page over any lane type; numbers in brackets are sections of Bourg & Bywalec, 2nd
// ed.
#pragma once

#include "kernels/math.hpp"
#include "kernels/vec3.hpp"

namespace salvo::kernels {
inline namespace SALVO_ISA {

/// Attraction to a fixed centre: a = GM d / (|d|^2 + softening^2)^(3/2), d from the particle to the
/// centre. `strength` is GM in m^3/s^2.   [3.2]
template <class V>
Vec3<V> point_gravity(Vec3<V> position, Vec3<V> center, V strength, V softening) {
  const Vec3<V> d = center - position;
  const V r2 = norm_squared(d) + softening * softening;
  const V cube = r2 * sqrt(r2);
  // At the very centre, without softening, the pull has no direction: zero.
  const auto usable = cube > V(0);
  return d * select(usable, strength / select(usable, cube, V(1)), V(0));
}

/// Drag linear in the flow past the body: a = -(c/m) u; `coefficient` is c in kg/s.   [4.2]
template <class V>
Vec3<V> linear_drag(Vec3<V> flow, V coefficient, V inverse_mass) {
  return -(flow * (coefficient * inverse_mass));
}

/// Drag quadratic in the flow past the body: a = -1/2 rho (Cd A)/m |u| u. `factor` is 1/2 rho (Cd
/// A)/m in 1/m.   [6.2]
template <class V>
Vec3<V> quadratic_drag(Vec3<V> flow, V factor) {
  return -(flow * (factor * norm(flow)));
}

/// Volume of a sphere, m^3.
template <class V>
V sphere_volume(V radius) {
  return V(4.0 / 3.0 * pi) * (radius * radius * radius);
}

/// Horizontal wind speed at `height` over that at the reference height: (h / h_ref)^exponent, zero
/// at and below the ground.
template <class V>
V power_law_profile(V height, V reference_height, V exponent) {
  const auto above = height > V(0);
  return select(above, pow(select(above, height, V(1)) / reference_height, exponent), V(0));
}

/// Horizontal wind speed at `height` over that at the reference height: ln(h / z0) / ln(h_ref /
/// z0), zero up to the roughness length z0. `inverse_log_reference` is 1 / ln(h_ref / z0).
template <class V>
V log_law_profile(V height, V roughness, V inverse_log_reference) {
  const auto above = height > roughness;
  return select(above, log(select(above, height, roughness) / roughness) * inverse_log_reference,
                V(0));
}

/// Number of sinusoids in a gust component.
inline constexpr int gust_terms = 8;

/// Sum over m = 1 .. 8 of A_m cos(m p) + B_m sin(m p), harmonics by the angle-addition recurrence
/// from one sine and cosine. `coefficients` holds A_1 .. A_8, B_1 .. B_8.
template <class V>
V gust_sum(V sine, V cosine, const typename V::Real* coefficients) {
  V s = sine;
  V c = cosine;
  V sum = V(coefficients[0]) * c + V(coefficients[gust_terms]) * s;
  for (int m = 1; m < gust_terms; ++m) {
    const V next = s * cosine + c * sine;
    c = c * cosine - s * sine;
    s = next;
    sum = sum + (V(coefficients[m]) * c + V(coefficients[gust_terms + m]) * s);
  }
  return sum;
}

/// Acceleration by a blast: outward, amplitude (r0 / max(r, r0))^exponent. `amplitude` is J/(m tau)
/// e^(-(t - t0)/tau) at this instant, zero before t0.   [18.4.2: falls with the cube of distance,
/// decays exponentially in time]
template <class V>
Vec3<V> blast(Vec3<V> position, Vec3<V> center, V amplitude, V reference_radius, int exponent) {
  const Vec3<V> d = position - center;
  const V r = norm(d);
  const auto usable = r > V(0);
  const V scale = amplitude * power(reference_radius / max(r, reference_radius), exponent);
  return d * select(usable, scale / select(usable, r, V(1)), V(0));
}

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
