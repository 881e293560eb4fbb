// The law of particles that touch, as plain numbers: SI units, double precision, no instruction
// set.
#pragma once

#include <cstdint>

#include "kernels/isa.hpp"

namespace salvo::models {

enum class ContactLawKind : std::uint8_t {
  linear_spring,  // F = k d, a dashpot beside it
  hertz_mindlin,  // elastic spheres: F = 4/3 E* sqrt(R*) d^(3/2)
  impulse,        // the book's impulse between all pairs that overlap and approach   [5.2-5.4]
};

struct ContactLaw {
  ContactLawKind kind = ContactLawKind::linear_spring;
  double normal_stiffness = 0;        ///< N/m, linear spring
  double tangential_ratio = 2.0 / 7;  ///< tangential stiffness over the normal one, linear spring
  double young_modulus = 0;           ///< Pa, Hertz
  double poisson_ratio = 0.3;         ///< Hertz
  double restitution = 0.5;           ///< of a head-on impact; the damping follows from it
  double tangential_damping = 0.5;    ///< over the normal damping
  double friction = 0;                ///< Coulomb coefficient
  double rolling_friction = 0;        ///< greatest rolling moment over R* and the normal force
  double surface_energy = 0;          ///< J/m^2; pull-off force 4 pi R* times it
  bool energy_budget = true;          ///< keep what each particle's contacts dissipate
  bool relax = false;                 ///< move apart particles that are emitted into others

  double push_out = 0.2;  ///< part of an overlap that a step of the impulse law takes back

  /// Particles have spin.
  bool turns() const { return friction > 0; }
  /// Contacts remember their tangential displacement.
  bool remembers() const { return turns() && kind != ContactLawKind::impulse; }
  /// And their rolling displacement.
  bool rolls() const { return remembers() && rolling_friction > 0; }
};

// Tagged with the instruction set, like everything that a kernel calls.
inline namespace SALVO_ISA {

/// E* of two spheres of one material, Pa.
inline double effective_young(const ContactLaw& law) {
  return law.young_modulus / (2 * (1 - law.poisson_ratio * law.poisson_ratio));
}
/// G* of two spheres of one material, Pa.
inline double effective_shear(const ContactLaw& law) {
  return law.young_modulus / (4 * (1 + law.poisson_ratio) * (2 - law.poisson_ratio));
}

}  // namespace SALVO_ISA

}  // namespace salvo::models
