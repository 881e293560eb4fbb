// Who overlaps whom in a state, found anew from the positions in double precision: what a frame
// reports of its contacts, and whether particles overlap when they are emitted. It does not look at
// the lists of the step, so a state that was read from a file gives the same numbers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "soa/table.hpp"
#include "solver/contact_diagnostics.hpp"
#include "solver/isa.hpp"
#include "solver/parallel.hpp"

namespace salvo::solver {

struct Setup;

/// Of a set-up with a contact law; the table sorted by id, at `time`. Sums go by id in the fixed
/// order.
ContactDiagnostics diagnose_contacts(const Setup& setup, double time, const soa::Table& particles,
                                     Isa isa, const Parallel& parallel);

/// Particles that are emitted where others or obstacles are.
struct BirthOverlaps {
  std::uint64_t pairs = 0;  ///< beyond the tolerance
  double worst = 0;         ///< overlap over the smaller radius
  soa::Id particle = 0;     ///< of the worst, the lower id
  soa::Id partner = 0;
  std::optional<std::size_t> obstacle{};  ///< in place of the partner: its place in the scene
  std::int64_t step = 0;                  ///< of the worst
};

/// Of the rows from `first_row` on with all rows and obstacles. Rows may be in any order.
BirthOverlaps find_birth_overlaps(const Setup& setup, double time, const soa::Table& particles,
                                  std::size_t first_row, double tolerance, Isa isa,
                                  const Parallel& parallel);

/// Moves the rows from `first_row` on until they overlap nothing by more than the tolerance, each
/// by the sum over what it overlaps in ascending id. False if that takes more than 1000 rounds.
bool move_apart(const Setup& setup, double time, soa::Table& particles, std::size_t first_row,
                double tolerance, Isa isa, const Parallel& parallel);

}  // namespace salvo::solver
