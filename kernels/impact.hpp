// Impact with restitution and Coulomb friction: impulses in N s along the line of action and across
// it.   [Bourg & Bywalec 5.2-5.4]
//
//   J = -(1 + e) v_rn / (1/m1 + 1/m2),   v1' = v1 + J n/m1,   v2' = v2 - J n/m2
//   friction: mu J against the slip, at most what stops it
//
// v_rn is the velocity of body 1 relative to body 2 along n, n points from body 2 to body 1, so
// bodies approach where v_rn < 0 and J is then positive. A fixed body has 1/m = 0.
#pragma once

#include "kernels/vec3.hpp"

namespace salvo::kernels {
inline namespace SALVO_ISA {

/// Impulse along the normal. Of bodies that turn, v_rn is that of the points of contact, and
/// `inverse_inertia` is n.[((r1 x n)/I1) x r1] + n.[((r2 x n)/I2) x r2], in 1/kg.
template <class V>
V normal_impulse(V relative_normal_velocity, V restitution, V inverse_mass_1, V inverse_mass_2,
                 V inverse_inertia = V(0)) {
  return -(relative_normal_velocity * (V(1) + restitution)) /
         (inverse_mass_1 + inverse_mass_2 + inverse_inertia);
}

/// Impulse of Coulomb friction: mu times the one along the normal, at most the one that makes the
/// contact stick.
template <class V>
V friction_impulse(V along_normal, V friction, V sticking) {
  return min(friction * along_normal, sticking);
}

/// The tangential impulse that stops the slip of a particle that does not turn: m |v_t|.
template <class V>
V sticking_impulse_of_particle(V mass, V slip) {
  return mass * slip;
}

/// The tangential impulse that makes a solid sphere roll on a fixed wall: 2/7 m |v_t|.
template <class V>
V sticking_impulse_of_sphere(V mass, V slip) {
  return V(2.0 / 7.0) * mass * slip;
}

/// Restitution of a particle on an obstacle that takes part in the impulse with a mass of its own
/// and yet stays where it is: (1 + e) M/(M + m) - 1, e itself for an infinite mass. Negative where
/// the obstacle is too light to turn the particle back.
template <class V>
V effective_restitution(V restitution, V mass, V inverse_obstacle_mass) {
  const V ratio = mass * inverse_obstacle_mass;
  return (restitution - ratio) / (V(1) + ratio);
}

/// What Coulomb friction leaves of the slip, as a factor in [0, 1]: 1 - mu |dv_n|/|v_t|, zero where
/// it would reverse. `change` is the change of the normal velocity: both impulses over the
/// particle's mass, m/s.
template <class V>
V friction_factor(V slip, V change, V friction) {
  const V loss = friction * change;
  const auto slips = slip > loss;
  return select(slips, V(1) - loss / select(slips, slip, V(1)), V(0));
}

/// What rounding left out of the product a b.   [Dekker 1971]
template <class V>
V product_error(V a, V b, V product) {
  const auto high_part = [](V x) {
    const V scaled = x * V(sizeof(typename V::Real) == 4 ? 4097.0 : 134217729.0);
    return scaled - (scaled - x);
  };
  const V a_high = high_part(a);
  const V b_high = high_part(b);
  const V a_low = a - a_high;
  const V b_low = b - b_high;
  return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
}

/// What rounding left out of the sum a + b.   [Knuth]
template <class V>
V sum_error(V a, V b, V sum) {
  const V b_part = sum - a;
  return (a - (sum - b_part)) + (b - b_part);
}

/// |n|^2 - 1 of a vector that is of unit length but for rounding, to full precision.
template <class V>
V unit_excess(Vec3<V> n) {
  const V x2 = n.x * n.x;
  const V y2 = n.y * n.y;
  const V z2 = n.z * n.z;
  const V xy = x2 + y2;
  const V xyz = xy + z2;
  return (xyz - V(1)) +
         (product_error(n.x, n.x, x2) + product_error(n.y, n.y, y2) + product_error(n.z, n.z, z2) +
          sum_error(x2, y2, xy) + sum_error(xy, z2, xyz));
}

/// v + n k (1 - excess) rounded once: a bounce off a fixed surface sees the same normal over and
/// over, and errors always to the same side would add up.
template <class V>
Vec3<V> add_along_normal(Vec3<V> v, Vec3<V> n, V k, V excess) {
  const auto component = [&](V start, V direction) {
    const V product = direction * k;
    const V sum = start + product;
    return sum + (sum_error(start, product, sum) +
                  (product_error(direction, k, product) - product * excess));
  };
  return {component(v.x, n.x), component(v.y, n.y), component(v.z, n.z)};
}

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
