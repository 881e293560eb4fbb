// The fields of Diagnostics, listed once: for frame files, reports and comparisons.
#pragma once

#include "solver/reduction.hpp"

namespace salvo::solver {

/// A field that is there when the particles touch, and not otherwise.
inline constexpr const char* first_contact_field = "pair_contacts";

/// Calls visit(name, unit, member) for every field: a count, a number or a vector. Those of the
/// contacts only where there are any.
template <class D, class Visit>
void for_each_field(D& diagnostics, const Visit& visit) {
  visit("count", "", diagnostics.count);
  visit("mass", "kg", diagnostics.mass);
  visit("momentum", "kg m/s", diagnostics.momentum);
  visit("center_of_mass", "m", diagnostics.center_of_mass);
  visit("kinetic_energy", "J", diagnostics.kinetic_energy);
  visit("potential_energy", "J", diagnostics.potential_energy);
  visit("lowest", "m", diagnostics.lowest);
  visit("highest", "m", diagnostics.highest);
  visit("max_speed", "m/s", diagnostics.max_speed);
  if (!diagnostics.contacts) return;
  auto& contacts = *diagnostics.contacts;
  visit(first_contact_field, "", contacts.pair_contacts);
  visit("wall_contacts", "", contacts.wall_contacts);
  visit("mean_coordination", "", contacts.mean_coordination);
  visit("max_overlap", "m", contacts.max_overlap);
  visit("mean_overlap", "m", contacts.mean_overlap);
  visit("max_relative_overlap", "", contacts.max_relative_overlap);
  visit("mean_relative_overlap", "", contacts.mean_relative_overlap);
  visit("rotational_energy", "J", contacts.rotational_energy);
  visit("elastic_energy", "J", contacts.elastic_energy);
  visit("damping_loss", "J", contacts.damping_loss);
  visit("friction_loss", "J", contacts.friction_loss);
  visit("momentum_error", "N s", contacts.momentum_error);
}

}  // namespace salvo::solver
