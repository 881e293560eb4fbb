// A world of particles: what a scene describes, stepped through time. The bits of its state are a
// function of the set-up and the step, and of nothing in Execution.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "soa/particle_fields.hpp"
#include "soa/table.hpp"
#include "solver/contact_solver.hpp"
#include "solver/contact_survey.hpp"
#include "solver/emitter.hpp"
#include "solver/isa.hpp"
#include "solver/parallel.hpp"
#include "solver/particle_pass.hpp"
#include "solver/reduction.hpp"
#include "solver/state_hash.hpp"

namespace salvo::solver {

/// What happens to a particle that becomes non-finite or leaves the domain.
enum class BadRowPolicy { stop, remove };

/// Everything that decides the bits.
struct Setup {
  soa::Precision precision = soa::Precision::float32;
  std::uint64_t seed = 0;
  double t0 = 0;  // s
  double dt = 0;  // s
  IntegratorKind integrator = IntegratorKind::semi_implicit_euler;
  models::ForceSettings forces;
  std::vector<models::Obstacle> obstacles;
  models::ContactSettings contact;
  /// Of particles that touch each other, and obstacles through the same law; none: they pass
  /// through each other, and `contact` says how they meet obstacles.
  std::optional<models::ContactLaw> contact_law;
  /// Greatest overlap at emission, over the smaller radius, under a contact law; none: any.
  std::optional<double> birth_tolerance;
  Domain domain;
  BadRowPolicy on_bad = BadRowPolicy::stop;
  std::vector<Emitter> emitters;
};

/// Everything that does not.
struct Execution {
  Isa isa = widest_isa();
  int threads = hardware_threads();
  std::int32_t pass_steps = 32;  ///< steps a pass, at most
  ContactTuning contact{};
};

/// Why and where a particle went bad.
struct BadRow {
  soa::Id id = 0;
  std::int64_t step = 0;  ///< the step at whose end it was first seen
  std::string column;     ///< such as "position.x"
  double value = 0;
  bool left_domain = false;  ///< else non-finite
};

/// A run that broke: a particle became non-finite or left the domain and the scene says stop.
class NumericalError : public std::runtime_error {
 public:
  explicit NumericalError(const BadRow& row);
  const BadRow& row() const { return row_; }

 private:
  BadRow row_;
};

/// Particles that touch were emitted into each other or an obstacle.
class OverlapAtBirth : public std::runtime_error {
 public:
  OverlapAtBirth(const Setup& setup, const BirthOverlaps& overlaps);
  const BirthOverlaps& overlaps() const { return overlaps_; }
  /// What to do.
  const std::string& hint() const { return hint_; }

 private:
  BirthOverlaps overlaps_;
  std::string hint_;
};

/// In words.
std::string describe(const BirthOverlaps& overlaps);

/// The particles that went for one reason, and the first of them.
struct Removals {
  std::uint64_t count = 0;
  std::optional<BadRow> first;
};

class World {
 public:
  /// At step 0, with what is emitted then; brings directions to unit length. Throws std::bad_alloc,
  /// std::invalid_argument (an instruction set that this binary or machine lacks, two emitters of
  /// one stream, a direction without length), OverlapAtBirth.
  World(const Setup& setup, const Execution& execution);

  const Setup& setup() const { return setup_; }
  const Execution& execution() const { return execution_; }
  std::int64_t step() const { return step_; }
  double time() const;
  /// Sorted by id; rows that are alive at this step.
  const soa::Table& particles() const;
  /// With a contact law: what the contacts remember, sorted by id and partner.
  const soa::Table& contacts() const;
  /// Where the time of the contacts went; null without a contact law.
  const ContactProfile* contact_profile() const;
  const Parallel& parallel() const { return *parallel_; }
  /// Impacts and rests since the start.
  ContactTally tally() const { return tally_; }
  /// Particles removed because they went bad, since the start.
  std::uint64_t removed() const { return removed_; }
  /// Those of them that left the domain, and those that became non-finite, since construction or
  /// restore().
  const Removals& left_domain() const { return left_domain_; }
  const Removals& non_finite() const { return non_finite_; }
  /// The first 100 of them, by step and id.
  const std::vector<BadRow>& removed_rows() const { return removed_rows_; }
  /// What overlapped when emitted and was moved apart, since construction.
  const BirthOverlaps& relaxed() const { return relaxed_; }
  /// Particle-steps taken since construction; for rates.
  std::uint64_t particle_steps() const { return particle_steps_; }

  /// Goes on in another way, to the same bits. Throws std::invalid_argument.
  void execute_as(const Execution& execution);

  /// Steps to `step`, at most 2^31 - 2. Throws NumericalError, naming the earliest bad row, or
  /// OverlapAtBirth; the world is of no further use then. Throws std::invalid_argument for a step
  /// in the past.
  void advance_to(std::int64_t step);

  Diagnostics diagnose() const;
  StateHash hash() const;

  /// Replaces the state by that of a checkpoint: tables of the same fields at `step`. Particles may
  /// be rows in any order; contacts are sorted by id and partner, else advance_to() throws
  /// std::invalid_argument. Without `contacts` none remembers anything.
  void restore(std::int64_t step, soa::Table particles, ContactTally tally, std::uint64_t removed,
               std::optional<soa::Table> contacts = std::nullopt);

  /// Which fields the set-up's tables store.
  static std::vector<bool> stored_fields(const Setup& setup);
  /// An empty table of the set-up, uniform values filled in.
  static soa::Table empty_table(const Setup& setup);
  /// Particles that the emitters will have emitted at the end of time.
  static std::uint64_t total_emitted(const Setup& setup);
  /// That a world can hold.
  static std::uint64_t most_particles(const Setup& setup);
  /// Bytes of state that a run of the set-up holds at most.
  static std::uint64_t state_bytes(const Setup& setup);

 private:
  struct TileResult {
    ContactTally tally;
    std::uint64_t steps_taken = 0;
  };

  void emit_due();
  void check_births(std::size_t first_row);
  std::int64_t pass_end(std::int64_t target) const;
  template <class T>
  void run_pass(std::int32_t steps, std::vector<T>& instants);
  template <class T>
  ParticlePass<T> whole_pass(std::int32_t steps, const std::vector<T>& instants);
  template <class T>
  void rerun_unsaved(const ParticlePass<T>& pass, std::size_t block, std::uint64_t rows);
  void report_bad_rows();
  void advance_contacts(std::int64_t steps);
  void make_solver();
  void settle();  // what a look at the state wants to see
  void remove_dead();
  void find_next_death(std::size_t first_row);  // among the rows from this one on

  std::unique_ptr<Setup> kept_setup_;  // stays in its place when the world is moved
  Setup& setup_;
  Execution execution_;
  std::unique_ptr<Parallel> parallel_;
  soa::Table particles_;
  soa::Table contacts_;
  std::unique_ptr<ContactSolver> contact_solver_;
  bool in_contact_solver_ = false;  // the state is there
  bool settled_ = true;             // and in the tables, too
  bool any_gone_ = false;           // rows of the contact solver that are to be removed
  std::vector<EmissionSchedule> schedules_;
  std::int64_t step_ = 0;
  std::int64_t next_death_ = soa::never;
  ContactTally tally_;
  std::uint64_t removed_ = 0;
  std::uint64_t particle_steps_ = 0;
  Removals left_domain_;
  Removals non_finite_;
  BirthOverlaps relaxed_;
  std::vector<BadRow> removed_rows_;
  std::vector<BadRow> bad_rows_;  // of the current pass
  std::vector<float> instants_single_;
  std::vector<double> instants_twice_;
  std::vector<std::uint64_t> unsaved_;
  std::vector<TileResult> tile_results_;
};

}  // namespace salvo::solver
