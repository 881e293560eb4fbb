// Two spheres that overlap, or a sphere and a wall: the force of a spring and a dashpot along the
// line of centres, and of a tangential spring that slips under Coulomb's law.   [Cundall & Strack
// 1979; Tsuji, Tanaka & Ishida 1992; Luding 2008]
//
//   F_n = max(F_elastic - c_n v_n, 0) - F_pull              v_n > 0 apart
//   F_t = -(k_t x + c_t v_t), at most mu (F_n + F_pull)     x the tangential displacement
//   M_r = -R* n x (k_t y + c_t v_r), at most mu_r R* (F_n + F_pull)
//
//   linear   F_elastic = k d           c_n = 2 zeta sqrt(k m*)
//   Hertz    F_elastic = 4/3 E* a d    c_n = 2 zeta sqrt(5/6 m* 2 E* a)    k_t = 8 G* a
//            a = sqrt(R* d)
//
// The dashpot never pulls. With that, a head-on impact has the restitution
//
//   e = exp(-2 zeta acos(zeta)/sqrt(1 - zeta^2))        arcosh and zeta^2 - 1 beyond zeta = 1
//
// under both laws: with y ~ d^(5/4) the damped Hertz spring has the phase plane of the linear one.
// [Schwager & Poeschel 2007; Antypov & Elliott 2011]
//
// All is seen from one sphere. Seen from its partner, normal, velocities and displacements change
// sign bit for bit, and so does the force.
#pragma once

#include "kernels/impact.hpp"
#include "kernels/math.hpp"
#include "kernels/vec3.hpp"

namespace salvo::kernels {
inline namespace SALVO_ISA {

/// An overlap as one of the two spheres sees it.
template <class V>
struct SphereContact {
  Vec3<V> normal;    // unit, from the partner to this sphere
  V overlap;         // d >= 0, m
  V lever;           // from the centre to the point of contact, m
  Vec3<V> velocity;  // of this sphere's point of contact relative to the partner's, m/s
  Vec3<V> rolling;   // R* (w - w_partner) x n, m/s
};

/// The springs and dashpots of a contact.
template <class V>
struct ContactSprings {
  V elastic;             // normal force of the spring, N
  V normal_damping;      // N s/m
  V tangential;          // stiffness, N/m
  V compliance;          // its inverse, m/N
  V tangential_damping;  // N s/m
};

/// What a law has to know of a pair but its overlap.
template <class V>
struct ContactPair {
  V mass;     // m*, kg
  V radius;   // R*, m
  V damping;  // of the normal dashpot: N s/m, under Hertz' law over the root of the stiffness dF/dd
};

template <class V>
struct LinearSpring {
  V normal_stiffness;      // N/m
  V tangential_stiffness;  // N/m
  V compliance;            // 1/tangential_stiffness, m/N
  V tangential_damping;    // over the normal damping

  V damping(V mass, V zeta) const { return V(2) * zeta * sqrt(normal_stiffness * mass); }
  ContactSprings<V> at(V overlap, const ContactPair<V>& pair) const {
    return {normal_stiffness * overlap, pair.damping, tangential_stiffness, compliance,
            tangential_damping * pair.damping};
  }
  V elastic_energy(V overlap, V /*radius*/) const {
    return V(0.5) * normal_stiffness * overlap * overlap;
  }
};

template <class V>
struct HertzMindlin {
  V young;               // E* = E/(2 (1 - nu^2)), Pa
  V shear;               // G* = G/(2 (2 - nu)), Pa
  V tangential_damping;  // over what the normal damping's formula gives with k_t

  V damping(V mass, V zeta) const { return V(2) * zeta * sqrt(V(5.0 / 6.0) * mass); }
  ContactSprings<V> at(V overlap, const ContactPair<V>& pair) const {
    const V contact_radius = sqrt(pair.radius * overlap);
    const V normal = V(2) * young * contact_radius;  // dF/dd
    const V tangential = V(8) * shear * contact_radius;
    return {V(2.0 / 3.0) * normal * overlap, pair.damping * sqrt(normal), tangential,
            V(1) / select(tangential > V(0), tangential, V(1)),
            tangential_damping * (pair.damping * sqrt(tangential))};
  }
  V elastic_energy(V overlap, V radius) const {
    return V(8.0 / 15.0) * young * sqrt(radius * overlap) * overlap * overlap;
  }
};

/// A spring and a dashpot in the plane of contact that slip beyond a greatest force.
template <class V>
struct SlipSpring {
  Vec3<V> after;  // the displacement at the end of the step, m
  Vec3<V> force;  // N, along the displacement: what it does is the opposite

  /// The displacement is turned into the plane by projection. That shortens it by the cosine of the
  /// angle that the contact turned in the step.
  SlipSpring(Vec3<V> displacement, Vec3<V> normal, Vec3<V> velocity,
             const ContactSprings<V>& springs, V greatest, V dt) {
    const Vec3<V> in_plane = displacement - normal * dot(displacement, normal);
    const Vec3<V> stretched = in_plane + velocity * dt;
    const Vec3<V> drag = velocity * springs.tangential_damping;
    const Vec3<V> trial = stretched * springs.tangential + drag;
    const V squared = norm_squared(trial);
    const auto slips = squared > greatest * greatest;
    const V kept = select(slips, greatest / sqrt(select(slips, squared, V(1))), V(1));
    force = trial * kept;
    after = select(slips, (force - drag) * springs.compliance, stretched);
  }
  /// Work done against the force in the step at a velocity, J, what the spring takes up included:
  /// that is given back, or lost when the contact ends.
  V work(Vec3<V> velocity, V dt) const { return dot(force, velocity) * dt; }
};

template <class V>
struct NormalForce {
  V pressing;  // without cohesion, N >= 0
  V along;     // with cohesion, along the normal, N
};

/// `apart`: relative velocity along the normal, m/s. The dashpot's heat is (elastic - pressing)
/// apart a second.
template <class V>
NormalForce<V> normal_force(const ContactSprings<V>& springs, V apart, V pull) {
  const V pressing = max(springs.elastic - springs.normal_damping * apart, V(0));
  return {pressing, pressing - pull};
}

/// The book's impulse between two spheres that approach, or a sphere and a wall: along the normal
/// J = -(1 + e) m* v_n, across it what stops the slip of solid spheres, 2/7 m* v_t, at most mu J.
/// N s.   [Bourg & Bywalec 5.2-5.4]
template <class V>
Vec3<V> approach_impulse(Vec3<V> normal, Vec3<V> slip, V apart, V mass, V restitution, V friction) {
  const V along = normal_impulse(apart, restitution, V(1) / mass, V(0));
  const V speed = norm(slip);
  const V across = friction_impulse(along, friction, sticking_impulse_of_sphere(mass, speed));
  return normal * along - slip * (across / select(speed > V(0), speed, V(1)));
}

/// The restitution of a head-on impact with damping ratio zeta >= 0.
inline double restitution_of(double zeta) {
  using S = ScalarLane<double>;
  if (zeta == 1) return exp(S(-2.0)).value();
  const S z(zeta);
  const S root = sqrt(abs(S(1) - z * z));
  const S angle = zeta < 1 ? acos(z) : log(z + root);
  return exp(-(S(2) * z * angle / root)).value();
}

/// The damping ratio of a restitution in (0, 1].
inline double damping_ratio_of(double restitution) {
  if (restitution >= 1) return 0;
  double low = 0;
  double high = 1;
  while (restitution_of(high) > restitution) high = high * 2;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (restitution_of(middle) > restitution ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// How long a head-on impact on a linear spring lasts, in units of sqrt(m*/k).
inline double impact_duration(double zeta) {
  using S = ScalarLane<double>;
  if (zeta == 1) return 2;
  const S z(zeta);
  const S root = sqrt(abs(S(1) - z * z));
  return (S(2) * (zeta < 1 ? acos(z) : log(z + root)) / root).value();
}

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
