#include "solver/world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "models/particle.hpp"
#include "solver/floating_point_environment.hpp"
#include "solver/instants.hpp"
#include "solver/tile.hpp"

namespace salvo::solver {

namespace {

using soa::ParticleField;

constexpr std::size_t remembered_rows = 100;

constexpr std::size_t index(ParticleField field) { return static_cast<std::size_t>(field); }

std::string describe(soa::Id id) {
  return fmt::format("{} (stream {}, serial {})", id, soa::stream_of(id), soa::serial_of(id));
}

std::string describe(const BadRow& row) {
  return fmt::format("particle {} {} at step {}: {} = {}", describe(row.id),
                     row.left_domain ? "left the domain" : "became non-finite", row.step,
                     row.column, row.value);
}

const Setup& checked(const Setup& setup) {
  if (!(setup.dt > 0)) throw std::invalid_argument("the time step must be positive");
  std::vector<std::uint64_t> streams;
  for (const Emitter& emitter : setup.emitters) {
    if (emitter.stream >= soa::max_stream) {
      throw std::invalid_argument(fmt::format("stream {} is too large", emitter.stream));
    }
    if (std::find(streams.begin(), streams.end(), emitter.stream) != streams.end()) {
      throw std::invalid_argument(fmt::format("two emitters have stream {}", emitter.stream));
    }
    streams.push_back(emitter.stream);
  }
  const std::uint64_t rows = World::total_emitted(setup);
  if (rows > World::most_particles(setup)) {
    throw std::invalid_argument(fmt::format("{} particles are more than the {} of one world", rows,
                                            World::most_particles(setup)));
  }
  return setup;
}

// Directions of unit length: a scene's are already, bit for bit.
Setup normalized(Setup setup) {
  setup.forces = completed(setup.forces);
  for (models::Obstacle& obstacle : setup.obstacles) {
    if (!models::is_normalized(obstacle)) obstacle = models::normalized(obstacle);
    if (!models::is_normalized(obstacle)) {
      throw std::invalid_argument("an obstacle's axis or rotation has no length");
    }
  }
  for (Emitter& emitter : setup.emitters) {
    const auto d = kernels::Vec3<kernels::ScalarLane<double>>{
        emitter.direction[0], emitter.direction[1], emitter.direction[2]};
    const double length = norm(d).value();
    if (!(length > 0)) throw std::invalid_argument("an emitter's direction has no length");
    constexpr double rounding = 1e-12;
    if (std::abs(length - 1) <= rounding) continue;
    for (double& component : emitter.direction) component /= length;
  }
  return setup;
}

const Execution& checked(const Execution& execution) {
  require_available(execution.isa);
  if (execution.pass_steps < 1) throw std::invalid_argument("a pass takes at least one step");
  return execution;
}

double drag_area_of(const Emitter& emitter) {
  return emitter.drag_coefficient
             ? *emitter.drag_coefficient * (kernels::pi * emitter.radius.a * emitter.radius.a)
             : emitter.drag_area.a;
}

}  // namespace

NumericalError::NumericalError(const BadRow& row) : std::runtime_error(describe(row)), row_(row) {}

std::string describe(const BirthOverlaps& overlaps) {
  const std::string pairs =
      overlaps.pairs == 1 ? "a pair overlaps" : fmt::format("{} pairs overlap", overlaps.pairs);
  const std::string partner = overlaps.obstacle ? fmt::format("obstacle {}", *overlaps.obstacle)
                                                : "particle " + describe(overlaps.partner);
  // Those that were moved apart may be of many steps.
  return fmt::format(
      "{} when emitted, {}at step {} by {:.3g} % of the smaller radius: particle {} "
      "and {}",
      pairs, overlaps.pairs == 1 ? "" : "the worst ", overlaps.step, 100 * overlaps.worst,
      describe(overlaps.particle), partner);
}

OverlapAtBirth::OverlapAtBirth(const Setup& setup, const BirthOverlaps& overlaps)
    : std::runtime_error(describe(overlaps)), overlaps_(overlaps) {
  hint_ = setup.contact_law->relax
              ? "they could not be moved apart in 1000 rounds: give them more room"
          : overlaps.obstacle ? "emit them away from the obstacle, or "
                              : "a larger spacing, or ";
  if (!setup.contact_law->relax) hint_ += "relax = true in [contact_law], which moves them apart";
}

std::vector<bool> World::stored_fields(const Setup& setup) {
  const FloatingPointEnvironment environment;
  std::vector<bool> stored(soa::particle_fields.size(), true);
  const auto same = [&](auto&& value) {
    return std::all_of(setup.emitters.begin(), setup.emitters.end(), [&](const Emitter& emitter) {
      return value(emitter) == value(setup.emitters.front());
    });
  };
  const auto never = [&](auto&& varies) {
    return std::none_of(setup.emitters.begin(), setup.emitters.end(), varies);
  };
  const auto is_jet = [](const Emitter& e) { return e.kind == EmitterKind::jet; };
  const auto dies = [](const Emitter& e) {
    return e.life.has_value() || e.kind == EmitterKind::book_explosion;
  };
  const auto drag_varies = [](const Emitter& e) {
    return e.drag_coefficient ? e.radius.varies() : e.drag_area.varies();
  };
  stored[index(ParticleField::mass)] = !(never([](const Emitter& e) { return e.mass.varies(); }) &&
                                         same([](const Emitter& e) { return e.mass.a; }));
  stored[index(ParticleField::radius)] =
      !(never([](const Emitter& e) { return e.radius.varies(); }) &&
        same([](const Emitter& e) { return e.radius.a; }));
  stored[index(ParticleField::drag_area)] = !(never(drag_varies) && same(drag_area_of));
  stored[index(ParticleField::birth)] = !(
      never(is_jet) && same([&](const Emitter& e) { return step_at(e.time, setup.t0, setup.dt); }));
  // A particle that the scene wants removed dies of it.
  stored[index(ParticleField::death)] = !never(dies) || setup.on_bad == BadRowPolicy::remove;
  stored[index(ParticleField::group)] = !same([](const Emitter& e) { return e.group; });
  const models::ContactLaw* law = setup.contact_law ? &*setup.contact_law : nullptr;
  stored[index(ParticleField::angular_velocity)] = law && law->turns();
  stored[index(ParticleField::residual)] = law && setup.precision == soa::Precision::float32;
  for (std::size_t f = 0; f < stored.size(); ++f) {
    if (soa::only_of_budgets(f)) stored[f] = law && law->energy_budget;
  }
  return stored;
}

soa::Table World::empty_table(const Setup& setup) {
  const FloatingPointEnvironment environment;
  soa::Table table(soa::particle_fields, setup.precision, stored_fields(setup));
  if (setup.emitters.empty()) return table;
  const Emitter& first = setup.emitters.front();
  table.set_uniform(index(ParticleField::mass), first.mass.a);
  table.set_uniform(index(ParticleField::radius), first.radius.a);
  table.set_uniform(index(ParticleField::drag_area), drag_area_of(first));
  table.set_uniform(index(ParticleField::birth),
                    static_cast<double>(step_at(first.time, setup.t0, setup.dt)));
  table.set_uniform(index(ParticleField::group), first.group);
  return table;
}

std::uint64_t World::most_particles(const Setup& setup) {
  return setup.contact_law ? most_touching : std::numeric_limits<std::uint32_t>::max();
}

std::uint64_t World::total_emitted(const Setup& setup) {
  const FloatingPointEnvironment environment;
  std::uint64_t total = 0;
  for (const Emitter& emitter : setup.emitters) {
    total += EmissionSchedule(emitter, setup.t0, setup.dt).total();
  }
  return total;
}

std::uint64_t World::state_bytes(const Setup& setup) {
  const std::vector<bool> stored = stored_fields(setup);
  std::uint64_t row = 0;
  for (std::size_t f = 0; f < stored.size(); ++f) {
    const soa::Field& field = soa::particle_fields[f];
    if (stored[f]) row += field.components * size_of(field.scalar, setup.precision);
  }
  return row * soa::padded(total_emitted(setup));
}

World::World(const Setup& setup, const Execution& execution)
    : kept_setup_(std::make_unique<Setup>(checked(setup))),
      setup_(*kept_setup_),
      execution_(checked(execution)),
      parallel_(std::make_unique<Parallel>(execution.threads)),
      particles_(empty_table(setup)),
      contacts_(empty_contacts(setup)) {
  const FloatingPointEnvironment environment;
  setup_ = normalized(setup_);
  make_solver();
  for (const Emitter& emitter : setup_.emitters) {
    schedules_.emplace_back(emitter, setup_.t0, setup_.dt);
  }
  particles_.reserve(total_emitted(setup_));
  emit_due();
  particles_.sort_by_id();
}

void World::execute_as(const Execution& execution) {
  const Execution& next = checked(execution);
  settle();
  execution_ = next;
  in_contact_solver_ = false;
  contact_solver_.reset();
  parallel_ = std::make_unique<Parallel>(execution.threads);
  make_solver();
}

void World::make_solver() {
  if (!setup_.contact_law) return;
  contact_solver_ = make_contact_solver(setup_, execution_.isa, execution_.contact, *parallel_);
}

const soa::Table& World::particles() const {
  // The state is the same before and after; only where it rests changes.
  const_cast<World*>(this)->settle();
  return particles_;
}

const soa::Table& World::contacts() const {
  const_cast<World*>(this)->settle();
  return contacts_;
}

const ContactProfile* World::contact_profile() const {
  return contact_solver_ ? &contact_solver_->profile() : nullptr;
}

void World::settle() {
  if (!in_contact_solver_ || settled_) return;
  const FloatingPointEnvironment environment;
  contact_solver_->store(particles_, contacts_);
  if (any_gone_) {
    next_death_ = 0;
    remove_dead();
    in_contact_solver_ = false;
    any_gone_ = false;
  }
  settled_ = true;
}

void World::emit_due() {
  std::size_t present = particles_.rows();
  for (std::size_t e = 0; e < schedules_.size(); ++e) {
    const std::uint64_t before = schedules_[e].emitted_before(step_);
    const std::uint64_t count = schedules_[e].emitted_before(step_ + 1) - before;
    if (count == 0) continue;
    if (in_contact_solver_) {
      settle();
      in_contact_solver_ = false;
      present = particles_.rows();
    }
    const std::size_t first = particles_.append(count);
    emit(setup_.emitters[e], setup_.seed, step_, setup_.dt, before, count, particles_, first,
         *parallel_);
  }
  find_next_death(present);
  if (setup_.contact_law && setup_.birth_tolerance && particles_.rows() > present) {
    check_births(present);
  }
}

void World::check_births(std::size_t first_row) {
  const double tolerance = *setup_.birth_tolerance;
  BirthOverlaps found = find_birth_overlaps(setup_, time(), particles_, first_row, tolerance,
                                            execution_.isa, *parallel_);
  if (found.pairs == 0) return;
  found.step = step_;
  if (!setup_.contact_law->relax ||
      !move_apart(setup_, time(), particles_, first_row, tolerance, execution_.isa, *parallel_)) {
    throw OverlapAtBirth(setup_, found);
  }
  const std::uint64_t pairs = relaxed_.pairs + found.pairs;
  if (found.worst > relaxed_.worst) relaxed_ = found;
  relaxed_.pairs = pairs;
}

void World::find_next_death(std::size_t first_row) {
  if (first_row == 0) next_death_ = soa::never;
  const auto* death = particles_.column<std::int32_t>(index(ParticleField::death));
  if (!death) return;
  for (std::size_t row = first_row; row < particles_.rows(); ++row) {
    next_death_ = std::min<std::int64_t>(next_death_, death[row]);
  }
}

double World::time() const {
  const FloatingPointEnvironment environment;
  return setup_.t0 + static_cast<double>(step_) * setup_.dt;
}

// A pass ends at the next emission, so that what is born takes part from then on.
std::int64_t World::pass_end(std::int64_t target) const {
  std::int64_t end = std::min(target, step_ + execution_.pass_steps);
  for (const EmissionSchedule& schedule : schedules_) {
    const std::int64_t next = schedule.next(step_ + 1);
    if (next >= 0) end = std::min(end, next);
  }
  return end;
}

void World::advance_to(std::int64_t target) {
  if (target < step_ || target >= soa::never) {
    throw std::invalid_argument(
        fmt::format("a world at step {} cannot advance to step {}", step_, target));
  }
  const FloatingPointEnvironment environment;
  while (step_ < target) {
    const auto steps = static_cast<std::int32_t>(pass_end(target) - step_);
    if (setup_.contact_law) {
      advance_contacts(steps);
      emit_due();
      continue;
    }
    if (setup_.precision == soa::Precision::float32) {
      run_pass(steps, instants_single_);
    } else {
      run_pass(steps, instants_twice_);
    }
    step_ += steps;
    emit_due();
  }
  if (in_contact_solver_) return;
  // Within, the dead only rest: their rows go when somebody looks.
  remove_dead();
  particles_.sort_by_id();
}

// Of particles that touch each step is a pass.
void World::advance_contacts(std::int64_t steps) {
  if (!in_contact_solver_) {
    remove_dead();
    particles_.sort_by_id();
    contact_solver_->load(particles_, contacts_);
    in_contact_solver_ = true;
  }
  // It has them now; a look at the state fills the tables again.
  if (std::exchange(settled_, false)) {
    release_stored(particles_);
    if (contacts_.rows() > 0) contacts_ = empty_contacts(setup_);
  }
  for (const std::int64_t end = step_ + steps; step_ < end; ++step_) {
    const bool deaths = next_death_ <= step_ + 1;
    const std::uint64_t before = contact_solver_->steps_taken();
    const auto bad = contact_solver_->advance(step_, deaths, setup_.on_bad == BadRowPolicy::remove);
    particle_steps_ += contact_solver_->steps_taken() - before;
    bad_rows_.assign(bad.begin(), bad.end());
    const bool removed = !bad.empty();
    report_bad_rows();
    if (deaths) next_death_ = contact_solver_->next_death(step_ + 1);
    // Those that are gone keep their rows until somebody looks.
    if (removed || deaths) any_gone_ = true;
  }
}

template <class T>
ParticlePass<T> World::whole_pass(std::int32_t steps, const std::vector<T>& instants) {
  ParticlePass<T> pass;
  pass.last_row = particles_.rows();
  for (std::size_t c = 0; c < 3; ++c) {
    pass.position[c] = particles_.column<T>(index(ParticleField::position), c);
    pass.velocity[c] = particles_.column<T>(index(ParticleField::velocity), c);
  }
  pass.mass = particles_.column<T>(index(ParticleField::mass));
  pass.radius = particles_.column<T>(index(ParticleField::radius));
  pass.drag_area = particles_.column<T>(index(ParticleField::drag_area));
  pass.uniform_mass = static_cast<T>(particles_.uniform(index(ParticleField::mass)));
  pass.uniform_radius = static_cast<T>(particles_.uniform(index(ParticleField::radius)));
  pass.uniform_drag_area = static_cast<T>(particles_.uniform(index(ParticleField::drag_area)));
  if (next_death_ < step_ + steps) {
    pass.death = particles_.column<std::int32_t>(index(ParticleField::death));
  }
  pass.first_step = static_cast<std::int32_t>(step_);
  pass.steps = steps;
  pass.dt = static_cast<T>(setup_.dt);
  pass.integrator = setup_.integrator;
  pass.forces = &setup_.forces;
  pass.obstacles = setup_.obstacles;
  pass.contact = setup_.contact;
  pass.domain = setup_.domain;
  pass.instants = instants.data();
  pass.instant_stride = models::instant_coefficients(setup_.forces.blasts.size());
  return pass;
}

namespace {

void advance_with(const ParticleKernels& kernels, ParticlePass<float>& pass) {
  kernels.advance_float32(pass);
}
void advance_with(const ParticleKernels& kernels, ParticlePass<double>& pass) {
  kernels.advance_float64(pass);
}

}  // namespace

template <class T>
void World::run_pass(std::int32_t steps, std::vector<T>& instants) {
  instant_coefficients(setup_.forces, setup_.seed, setup_.t0, setup_.dt, step_, steps, instants);
  const ParticlePass<T> whole = whole_pass(steps, instants);
  const ParticleKernels& kernels = particle_kernels(execution_.isa);
  const std::size_t rows = particles_.rows();
  const std::size_t tiles = tiles_of(rows);
  unsaved_.resize(soa::padded(rows) / soa::block_rows);
  tile_results_.resize(tiles);
  parallel_->for_each(tiles, [&](std::size_t tile) {
    ParticlePass<T> pass = whole;
    pass.first_row = tile * tile_rows;
    pass.last_row = std::min(rows, pass.first_row + tile_rows);
    pass.unsaved = unsaved_.data() + pass.first_row / soa::block_rows;
    advance_with(kernels, pass);
    tile_results_[tile] = {pass.tally, pass.steps_taken};
  });
  for (std::size_t block = 0; block < unsaved_.size(); ++block) {
    if (unsaved_[block] != 0) rerun_unsaved(whole, block, unsaved_[block]);
  }
  report_bad_rows();
  for (const TileResult& tile : tile_results_) {
    tally_.impacts += tile.tally.impacts;
    tally_.rests += tile.tally.rests;
    particle_steps_ += tile.steps_taken;
  }
}

// Steps the rows of a block that the pass left alone one step at a time, on copies, to find which
// went bad, when and how.
template <class T>
void World::rerun_unsaved(const ParticlePass<T>& pass, std::size_t block, std::uint64_t rows) {
  constexpr std::size_t size = soa::block_rows;
  alignas(soa::alignment) T copies[9][size] = {};
  alignas(soa::alignment) std::int32_t death[size];
  bool removed[size] = {};
  std::size_t source[size];
  std::size_t count = 0;
  T* const columns[9] = {pass.position[0],
                         pass.position[1],
                         pass.position[2],
                         pass.velocity[0],
                         pass.velocity[1],
                         pass.velocity[2],
                         const_cast<T*>(pass.mass),
                         const_cast<T*>(pass.radius),
                         const_cast<T*>(pass.drag_area)};
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t row = block * size + i;
    if ((rows >> i & 1) == 0 || row >= pass.last_row) continue;
    for (std::size_t c = 0; c < 9; ++c) {
      if (columns[c]) copies[c][count] = columns[c][row];
    }
    death[count] = pass.death ? pass.death[row] : soa::never;
    source[count++] = row;
  }

  ParticlePass<T> single = pass;
  for (std::size_t c = 0; c < 3; ++c) {
    single.position[c] = copies[c];
    single.velocity[c] = copies[3 + c];
  }
  single.mass = pass.mass ? copies[6] : nullptr;
  single.radius = pass.radius ? copies[7] : nullptr;
  single.drag_area = pass.drag_area ? copies[8] : nullptr;
  single.death = death;
  single.first_row = 0;
  single.last_row = count;
  single.steps = 1;
  single.keep_bad = true;
  std::uint64_t unsaved = 0;
  single.unsaved = &unsaved;

  static constexpr const char* column_names[6] = {"position.x", "position.y", "position.z",
                                                  "velocity.x", "velocity.y", "velocity.z"};
  for (std::int32_t k = 0; k < pass.steps; ++k) {
    single.first_step = pass.first_step + k;
    single.instants = pass.instants + 2 * static_cast<std::size_t>(k) * pass.instant_stride;
    advance_with(particle_kernels(execution_.isa), single);
    for (std::size_t i = 0; i < count; ++i) {
      if (removed[i] || death[i] <= single.first_step) continue;
      for (std::size_t c = 0; c < 6; ++c) {
        const auto value = static_cast<double>(copies[c][i]);
        const bool outside = setup_.domain.bounded && c < 3 &&
                             (copies[c][i] < static_cast<T>(setup_.domain.lowest[c]) ||
                              copies[c][i] > static_cast<T>(setup_.domain.highest[c]));
        if (std::isfinite(value) && !outside) continue;
        const BadRow bad{particles_.ids()[source[i]], single.first_step + 1, column_names[c], value,
                         std::isfinite(value)};
        bad_rows_.push_back(bad);
        death[i] = single.first_step + 1;
        removed[i] = true;
        // Nobody sees it again, and at zero it rests without being looked at in every pass.
        for (auto& column : copies) column[i] = 0;
        break;
      }
    }
  }
  particle_steps_ += single.steps_taken;
  tally_.impacts += single.tally.impacts;
  tally_.rests += single.tally.rests;
  auto* deaths = particles_.column<std::int32_t>(index(ParticleField::death));
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t c = 0; c < 6; ++c) columns[c][source[i]] = copies[c][i];
    if (removed[i] && deaths) {
      deaths[source[i]] = death[i];
      next_death_ = std::min<std::int64_t>(next_death_, death[i]);
    }
  }
}

// By step and id, so that the report does not depend on how many steps a pass takes.
void World::report_bad_rows() {
  if (bad_rows_.empty()) return;
  std::stable_sort(bad_rows_.begin(), bad_rows_.end(),
                   [](const BadRow& a, const BadRow& b) {  // exact-set: (step, id) is unique
                     return std::pair(a.step, a.id) < std::pair(b.step, b.id);
                   });
  if (setup_.on_bad == BadRowPolicy::stop) throw NumericalError(bad_rows_.front());
  removed_ += bad_rows_.size();
  for (const BadRow& row : bad_rows_) {
    Removals& removals = row.left_domain ? left_domain_ : non_finite_;
    if (removals.count++ == 0) removals.first = row;
    if (removed_rows_.size() < remembered_rows) removed_rows_.push_back(row);
  }
  bad_rows_.clear();
}

void World::remove_dead() {
  if (next_death_ > step_) return;
  const auto* death = particles_.column<std::int32_t>(index(ParticleField::death));
  std::vector<std::uint8_t> keep(particles_.rows());
  for (std::size_t row = 0; row < keep.size(); ++row) keep[row] = death[row] > step_ ? 1 : 0;
  particles_.compact(keep);
  find_next_death(0);
}

Diagnostics World::diagnose() const {
  const FloatingPointEnvironment environment;
  Diagnostics diagnostics = solver::diagnose(particles(), setup_.forces, *parallel_);
  if (setup_.contact_law) {
    diagnostics.contacts =
        diagnose_contacts(setup_, time(), particles(), execution_.isa, *parallel_);
    std::uint64_t emitted = 0;
    for (const EmissionSchedule& schedule : schedules_) {
      emitted += schedule.emitted_before(step_ + 1);
    }
    // What those who are gone had is gone with them.
    if (particles().rows() != emitted) {
      constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
      diagnostics.contacts->damping_loss = unknown;
      diagnostics.contacts->friction_loss = unknown;
      diagnostics.contacts->momentum_error.fill(unknown);
    }
  }
  return diagnostics;
}

StateHash World::hash() const {
  StateHash hash = state_hash(particles(), *parallel_);
  if (remembers_contacts(setup_)) append(hash, state_hash(contacts(), *parallel_));
  return hash;
}

void World::restore(std::int64_t step, soa::Table particles, ContactTally tally,
                    std::uint64_t removed, std::optional<soa::Table> contacts) {
  step_ = step;
  in_contact_solver_ = false;
  settled_ = true;
  any_gone_ = false;
  particles_ = std::move(particles);
  particles_.sort_by_id();
  contacts_ = contacts ? std::move(*contacts) : empty_contacts(setup_);
  particles_.reserve(total_emitted(setup_));
  tally_ = tally;
  removed_ = removed;
  left_domain_ = {};
  non_finite_ = {};
  removed_rows_.clear();
  find_next_death(0);
}

}  // namespace salvo::solver
