// The fields of Diagnostics, listed once: for frame files, reports and comparisons.
#pragma once

#include "solver/reduction.hpp"

namespace salvo::solver {

/// Calls visit(name, unit, member) for every field: a count, a number or a vector.
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
}

}  // namespace salvo::solver
