// Reductions of a fixed shape: leaves of 4096 rows, 16 virtual lanes in each whatever the
// instruction set, lanes and leaves combined by a pairwise tree. The sum is a function of the rows
// in id order and of nothing else.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "models/force_settings.hpp"
#include "soa/table.hpp"
#include "solver/contact_diagnostics.hpp"
#include "solver/parallel.hpp"

namespace salvo::solver {

inline constexpr std::size_t leaf_rows = 4096;
inline constexpr std::size_t virtual_lanes = 16;

/// The sum in the fixed order; an empty sum is +0.
double fixed_order_sum(std::span<const double> values);

/// What a frame reports of its particles. Bounds of no particle are NaN.
struct Diagnostics {
  std::uint64_t count = 0;
  double mass = 0;                         // kg
  std::array<double, 3> momentum{};        // kg m/s
  std::array<double, 3> center_of_mass{};  // m; NaN without mass
  double kinetic_energy = 0;               // J
  double potential_energy = 0;  // J, of uniform and point gravity; zero at the origin, at infinity
  std::array<double, 3> lowest{};                // m
  std::array<double, 3> highest{};               // m
  double max_speed = 0;                          // m/s
  std::optional<ContactDiagnostics> contacts{};  // of particles that touch
};

/// The table must be sorted by id.
Diagnostics diagnose(const soa::Table& particles, const models::ForceSettings& forces,
                     const Parallel& parallel);

}  // namespace salvo::solver
