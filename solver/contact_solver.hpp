// Steps particles that touch each other and obstacles. Between two looks at the state the particles
// rest here, in an order of the broad phase's choice, with the lists of who is near whom
// and what each contact remembers; store() writes them back by id.
//
// Lists have a margin and are used until a particle may have gone half of it. They are taken from
// lists of a wider margin for as long as those can be, and then from cells, which also sorts the
// rows. The margins, the size of the cells, how often rows are sorted and the threads are tuning: a
// list is a superset of the contacts in ascending id, whatever they are.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "soa/table.hpp"
#include "solver/contact_pass.hpp"
#include "solver/parallel.hpp"

namespace salvo::solver {

struct Setup;
struct BadRow;

/// How the broad phase goes about it; decides no bit.
struct ContactTuning {
  double margin = 0;               ///< of the lists, m; 0: chosen, and adapted to the motion
  double cell_scale = 1;           ///< cells larger by this than they need be
  std::int64_t list_interval = 0;  ///< steps after which lists are taken anew; 0: when they must be
  /// Of the lists that those are taken from, in margins; 0: chosen. With 1 they are built from
  /// cells every time.
  double outer_margins = 0;
};

/// Where the time of the steps went and what was done, since construction.
struct ContactProfile {
  double sort_seconds = 0;
  double list_seconds = 0;
  double step_seconds = 0;
  double transfer_seconds = 0;  ///< to and from the tables
  std::uint64_t steps = 0;
  std::uint64_t sorts = 0;  ///< by cells, with the outer lists
  std::uint64_t list_builds = 0;
  std::uint64_t list_entries = 0;  ///< of all builds
  std::uint64_t list_slots = 0;    ///< the same with what fills up the groups
};

class ContactSolver {
 public:
  virtual ~ContactSolver() = default;

  /// Takes over particles sorted by id, and the contacts between them. The ids stay where they are
  /// until store(), which needs nothing else of the tables.
  virtual void load(const soa::Table& particles, const soa::Table& contacts) = 0;
  /// One step, from `step`. `instants` are the coefficients of its forces. Returns the rows that
  /// went bad, by id; with `remove` they are gone.
  virtual std::span<const BadRow> advance(std::int64_t step, bool watch_deaths, bool remove) = 0;
  /// The first step at which one of the particles is gone, as of the last load or call.
  virtual std::int64_t next_death(std::int64_t after) const = 0;
  /// Writes the state back to the table it came from, and the contacts to theirs.
  virtual void store(soa::Table& particles, soa::Table& contacts) = 0;

  std::uint64_t steps_taken() const { return steps_taken_; }
  const ContactProfile& profile() const { return profile_; }

 protected:
  std::uint64_t steps_taken_ = 0;
  ContactProfile profile_;
};

/// Particles that rows, and the contacts of all together, can be numbered for.
inline constexpr std::uint64_t most_touching = std::uint64_t{1} << 28;

/// Setup, execution and parallel outlive it.
std::unique_ptr<ContactSolver> make_contact_solver(const Setup& setup, Isa isa,
                                                   const ContactTuning& tuning,
                                                   const Parallel& parallel);

/// Whether contacts have a memory, which is state.
bool remembers_contacts(const Setup& setup);
/// Bytes that so many particles take in the solver besides the tables, in a dense pile: what their
/// lists and contacts need depends on where they are.
std::uint64_t contact_solver_bytes(const Setup& setup, std::uint64_t particles);
/// Bytes of a table of the contacts of so many particles in a dense pile.
std::uint64_t contact_table_bytes(const Setup& setup, std::uint64_t particles);
/// Gives back the columns of a table that was loaded, as far as store() fills them again.
void release_stored(soa::Table& particles);
/// An empty table of contacts for the set-up.
soa::Table empty_contacts(const Setup& setup);

}  // namespace salvo::solver
