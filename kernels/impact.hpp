// Impact with restitution and Coulomb friction: impulses in N s along the line of action and across it.
//
//   J = -(1 + e) v_rn / (1/m1 + 1/m2),   v1' = v1 + J n/m1,   v2' = v2 - J n/m2        [Bourg & Bywalec 5.2-5.3]
//   friction: mu J against the slip, at most what stops it                            [5.4]
//
// v_rn is the velocity of body 1 relative to body 2 along n, n points from body 2 to body 1, so bodies approach where
// v_rn < 0 and J is then positive. A fixed body has 1/m = 0.
#pragma once

#include "kernels/vec3.hpp"

namespace salvo::kernels {
inline namespace SALVO_ISA {

/// Impulse along the normal: of two bodies that approach at -v_rn.
template <class V>
V normal_impulse(V relative_normal_velocity, V restitution, V inverse_mass_1, V inverse_mass_2) {
  return -(relative_normal_velocity * (V(1) + restitution)) / (inverse_mass_1 + inverse_mass_2);
}

/// The same with rotation: `inverse_inertia` is n.[((r1 x n)/I1) x r1] + n.[((r2 x n)/I2) x r2] in 1/kg, v_rn is taken at
/// the point of contact.
template <class V>
V normal_impulse(V relative_normal_velocity, V restitution, V inverse_mass_1, V inverse_mass_2,
                 V inverse_inertia) {
  return -(relative_normal_velocity * (V(1) + restitution)) /
         (inverse_mass_1 + inverse_mass_2 + inverse_inertia);
}

/// Impulse of Coulomb friction: mu times the normal impulse, at most the one that makes the contact stick.
template <class V>
V friction_impulse(V normal_impulse, V friction, V sticking_impulse) {
  return min(friction * normal_impulse, sticking_impulse);
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

/// Restitution of a particle on an obstacle that takes part in the impulse with a mass of its own and yet stays where it is:
/// (1 + e) M/(M + m) - 1. Negative where the obstacle is too light to turn the particle back.
template <class V>
V effective_restitution(V restitution, V mass, V inverse_obstacle_mass) {
  return (V(1) + restitution) / (V(1) + mass * inverse_obstacle_mass) - V(1);
}

/// The slip that friction leaves of `slip`, for a particle whose normal velocity has changed by `normal_change`: both over
/// the particle's mass, so in m/s. A factor in [0, 1].
template <class V>
V friction_factor(V slip, V normal_change, V friction) {
  const V loss = friction * normal_change;
  return select(slip > loss, V(1) - loss / select(slip > loss, slip, V(1)), V(0));
}

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
