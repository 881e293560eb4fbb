#include "solver/contact_solver.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <span>

#include "kernels/sphere_contact.hpp"
#include "models/particle.hpp"
#include "soa/contact_fields.hpp"
#include "soa/particle_fields.hpp"
#include "solver/contact_memory.hpp"
#include "solver/contact_rows.hpp"
#include "solver/instants.hpp"
#include "solver/neighbor_lists.hpp"
#include "solver/wall_lists.hpp"
#include "solver/walls.hpp"
#include "solver/world.hpp"

namespace salvo::solver {

namespace {

using soa::ParticleField;

template <class Field>
constexpr std::size_t index(Field field) {
  return static_cast<std::size_t>(field);
}

// The columns of the budget.
struct BudgetColumn {
  ParticleField field;
  std::size_t component;
};
constexpr std::array<BudgetColumn, 5> budget_columns{{{ParticleField::damping_loss, 0},
                                                      {ParticleField::friction_loss, 0},
                                                      {ParticleField::contact_impulse, 0},
                                                      {ParticleField::contact_impulse, 1},
                                                      {ParticleField::contact_impulse, 2}}};

// The fields that steps change, but for deaths, which the world watches.
constexpr std::array stepped_fields{ParticleField::position,       ParticleField::residual,
                                    ParticleField::velocity,       ParticleField::angular_velocity,
                                    ParticleField::damping_loss,   ParticleField::friction_loss,
                                    ParticleField::contact_impulse};

// Two come nearer by twice what each goes. A path is a sum of rounded lengths: in as many steps as
// a list is used it is short by less than a thousandth.
constexpr double covered = 0.499;

class Stopwatch {
 public:
  explicit Stopwatch(double& seconds) : seconds_(seconds) {}
  ~Stopwatch() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

template <class T>
class Solver final : public ContactSolver {
 public:
  Solver(const Setup& setup, Isa isa, const ContactTuning& tuning, const Parallel& parallel)
      : setup_(setup),
        kernels_(contact_kernels(isa)),
        tuning_(tuning),
        parallel_(parallel),
        walls_(setup.obstacles),
        lists_(kernels_, parallel),
        memory_(*setup.contact_law, parallel) {
    damping_ratio_ = kernels::damping_ratio_of(setup.contact_law->restitution);
  }

  void load(const soa::Table& particles, const soa::Table& contacts) override;
  std::span<const BadRow> advance(std::int64_t step, bool watch_deaths, bool remove) override;
  std::int64_t next_death(std::int64_t after) const override;
  void store(soa::Table& particles, soa::Table& contacts) override;

 private:
  using Place = SpherePlace<T>;
  using Motion = SphereMotion<T>;
  const models::ContactLaw& law() const { return *setup_.contact_law; }

  template <class Task>
  void for_rows(const Task& task) const {
    solver::for_rows(parallel_, rows_, task);
  }
  static Place nowhere() {
    const auto far = static_cast<T>(nowhere_position);
    return {{far, far, far}, static_cast<T>(no_radius)};
  }
  static Motion at_rest() {
    Motion motion{};
    motion.mass = 1;
    return motion;
  }
  bool lives(std::size_t row) const { return places_[0][row].radius > 0; }
  Sight sight(std::size_t row) const {
    const Place& place = places_[0][row];
    Sight sight;
    for (std::size_t c = 0; c < 3; ++c) {
      sight.position[c] = seen_by_cells(static_cast<double>(place.position[c]) +
                                        static_cast<double>(motions_[0][row].residual[c]));
    }
    sight.radius = place.radius > 0 ? static_cast<double>(place.radius) : -1.0;
    return sight;
  }

  // Of the lists, m.
  struct Margins {
    double inner;
    double outer;
  };
  void make_room(std::size_t n);
  void build_lists();
  void sort_rows();
  Margins margins() const;
  void move_rows();
  void forget_paths();
  void find_bad(std::int64_t step, bool remove);

  const Setup& setup_;
  const ContactKernels& kernels_;
  const ContactTuning tuning_;
  const Parallel& parallel_;
  Walls walls_;
  double damping_ratio_;

  std::size_t rows_ = 0;  // groups are whole: those after the particles are nowhere
  std::size_t particles_ = 0;
  const soa::Id* ids_ = nullptr;  // by rank
  soa::Array<Place> places_[2];   // the state, and where the next one goes
  soa::Array<Motion> motions_[2];
  soa::Array<std::uint32_t> rank_;  // place by id of each row
  soa::Array<T> drag_area_;
  soa::Array<std::int32_t> death_;
  std::array<soa::Array<T>, budget_columns.size()> budget_;
  soa::Array<T> approaches_;
  soa::Array<T> moved_;  // room to put a column in order
  soa::Array<std::int32_t> moved_steps_;
  T uniform_drag_area_ = 0;
  bool equal_ = false;  // of mass and radius
  T uniform_mass_ = 1;
  T uniform_radius_ = 0;
  bool has_drag_area_ = false;
  bool has_death_ = false;

  bool listed_ = false;
  NeighborLists::Extent extent_;  // when the rows were sorted
  double margin_ = 0;
  double outer_margin_ = 0;
  double rounding_ = 0;        // that positions in single precision may be off, m
  double wall_path_ = 0;       // m, of the walls since the lists were built
  double longest_path_ = 0;    // m, of the particles
  double outer_path_ = 0;      // m, of the particles between the outer lists and the inner ones
  std::int64_t list_age_ = 0;  // steps
  NeighborLists lists_;
  WallLists<T> wall_lists_;
  ContactMemory<T> memory_;

  std::vector<T> instants_;
  std::vector<BadRow> bad_rows_;
  struct TaskResult {
    double longest_path;
    std::uint64_t steps_taken;
    bool bad;
  };
  std::vector<TaskResult> results_;
};

template <class T>
void Solver<T>::load(const soa::Table& particles, const soa::Table& contacts) {
  const Stopwatch watch(profile_.transfer_seconds);
  particles_ = particles.rows();
  rows_ = tasks_of(particles_, group_rows) * group_rows;
  ids_ = particles.ids();
  const auto column = [&](ParticleField field, std::size_t c = 0) {
    return particles.column<T>(index(field), c);
  };
  const auto uniform = [&](ParticleField field) {
    return static_cast<T>(particles.uniform(index(field)));
  };
  const T* mass = column(ParticleField::mass);
  const T* radius = column(ParticleField::radius);
  const T* drag_area = column(ParticleField::drag_area);
  const auto* death = particles.column<std::int32_t>(index(ParticleField::death));
  has_drag_area_ = drag_area != nullptr;
  has_death_ = death != nullptr;
  uniform_drag_area_ = uniform(ParticleField::drag_area);
  equal_ = mass == nullptr && radius == nullptr;
  uniform_mass_ = uniform(ParticleField::mass);
  uniform_radius_ = uniform(ParticleField::radius);
  make_room(0);
  rank_.resize(rows_);
  if (has_drag_area_) drag_area_.resize(rows_);
  if (has_death_) death_.resize(rows_);
  std::array<const T*, budget_columns.size()> budget{};
  for (std::size_t i = 0; i < budget.size() && law().energy_budget; ++i) {
    budget[i] = column(budget_columns[i].field, budget_columns[i].component);
    budget_[i].resize(rows_);
  }
  for_rows([&](std::size_t first, std::size_t last) {
    for (std::size_t row = first; row < last; ++row) {
      rank_[row] = static_cast<std::uint32_t>(row);
      const bool real = row < particles_;
      Place& place = places_[0][row];
      Motion& motion = motions_[0][row];
      place = nowhere();
      motion = at_rest();
      if (has_drag_area_) drag_area_[row] = real ? drag_area[row] : T(0);
      if (has_death_) death_[row] = real ? death[row] : soa::never;
      for (std::size_t i = 0; i < budget.size(); ++i) {
        if (budget[i]) budget_[i][row] = real ? budget[i][row] : T(0);
      }
      if (!real) continue;
      const auto fill = [&](ParticleField field, T* to) {
        for (std::size_t c = 0; c < 3; ++c) {
          const T* from = column(field, c);
          to[c] = from ? from[row] : T(0);
        }
      };
      fill(ParticleField::position, place.position);
      fill(ParticleField::residual, motion.residual);
      fill(ParticleField::velocity, motion.velocity);
      fill(ParticleField::angular_velocity, motion.spin);
      place.radius = radius ? radius[row] : uniform(ParticleField::radius);
      motion.mass = mass ? mass[row] : uniform(ParticleField::mass);
    }
  });

  memory_.load(contacts, {ids_, particles_}, rows_);
  listed_ = false;
}

template <class T>
void Solver<T>::make_room(std::size_t n) {
  places_[n].resize(rows_ + 1);
  motions_[n].resize(rows_ + 1);
  places_[n][rows_] = nowhere();
  motions_[n][rows_] = at_rest();
}

template <class T>
std::int64_t Solver<T>::next_death(std::int64_t after) const {
  std::int64_t next = soa::never;
  if (!has_death_) return next;
  for (std::size_t row = 0; row < rows_; ++row) {
    if (death_[row] > after) next = std::min<std::int64_t>(next, death_[row]);
  }
  return next;
}

template <class T>
std::span<const BadRow> Solver<T>::advance(std::int64_t step, bool watch_deaths, bool remove) {
  constexpr std::int64_t oldest = 8192;
  if (places_[1].size() != rows_ + 1) make_room(1);
  walls_.place(setup_.t0 + static_cast<double>(step) * setup_.dt);
  if (!listed_ || longest_path_ + wall_path_ > covered * margin_ || list_age_ >= oldest ||
      (tuning_.list_interval > 0 && list_age_ >= tuning_.list_interval)) {
    build_lists();
  }
  const Stopwatch watch(profile_.step_seconds);
  instant_coefficients(setup_.forces, setup_.seed, setup_.t0, setup_.dt, step, 1, instants_);
  ContactPass<T> whole;
  whole.from = {places_[0].data(), motions_[0].data()};
  whole.to = {places_[1].data(), motions_[1].data()};
  whole.first_slot = lists_.inner().first_slot.data();
  whole.neighbor = lists_.inner().neighbor.data();
  whole.first_wall_slot = wall_lists_.first_slot.data();
  whole.wall_part = wall_lists_.part.data();
  whole.wall_memory = wall_lists_.memory();
  whole.walls = walls_.now();
  whole.wall_parts = walls_.parts();
  whole.drag_area = has_drag_area_ ? drag_area_.data() : nullptr;
  whole.uniform_drag_area = uniform_drag_area_;
  whole.equal = equal_;
  whole.uniform_mass = uniform_mass_;
  whole.uniform_radius = uniform_radius_;
  whole.death = watch_deaths && has_death_ ? death_.data() : nullptr;
  if (law().energy_budget) {
    whole.damping_loss = budget_[0].data();
    whole.friction_loss = budget_[1].data();
    for (std::size_t c = 0; c < 3; ++c) whole.contact_impulse[c] = budget_[2 + c].data();
  }
  whole.step = static_cast<std::int32_t>(step);
  whole.dt = static_cast<T>(setup_.dt);
  whole.law = &law();
  whole.damping_ratio = damping_ratio_;
  whole.forces = &setup_.forces;
  whole.instants = instants_.data();
  whole.domain = setup_.domain;

  const std::size_t groups = rows_ / group_rows;
  const std::size_t tasks = tasks_of(groups, groups_per_task);
  results_.resize(tasks);
  const auto part = [&](std::size_t task) {
    ContactPass<T> pass = whole;
    pass.first_group = task * groups_per_task;
    pass.last_group = std::min(groups, pass.first_group + groups_per_task);
    return pass;
  };
  if (law().kind == models::ContactLawKind::impulse) {
    approaches_.resize(rows_ + group_rows);
    whole.approaches = approaches_.data();
    parallel_.for_each(tasks, [&](std::size_t task) {
      ContactPass<T> pass = part(task);
      if constexpr (sizeof(T) == 4) {
        kernels_.count_float32(pass);
      } else {
        kernels_.count_float64(pass);
      }
    });
  }
  parallel_.for_each(tasks, [&](std::size_t task) {
    ContactPass<T> pass = part(task);
    // What the contacts remember afterwards: as many as there are neighbors, at most.
    thread_local std::vector<T> after;
    const std::size_t entries =
        (whole.first_slot[pass.last_group] - whole.first_slot[pass.first_group]) * group_rows;
    after.resize(std::max(after.size(), memory_.columns() * entries));
    pass.history = memory_.history(task, after.data(), entries);
    if constexpr (sizeof(T) == 4) {
      kernels_.advance_float32(pass);
    } else {
      kernels_.advance_float64(pass);
    }
    memory_.take(task, pass.history);
    results_[task] = {pass.longest_path, pass.steps_taken, pass.bad};
  });
  places_[0].swap(places_[1]);
  motions_[0].swap(motions_[1]);
  longest_path_ = 0;
  bool bad = false;
  for (const TaskResult& result : results_) {
    longest_path_ = std::max(longest_path_, result.longest_path);
    steps_taken_ += result.steps_taken;
    bad = bad || result.bad;
  }
  wall_path_ += walls_.fastest() * setup_.dt;
  ++list_age_;
  ++profile_.steps;
  bad_rows_.clear();
  if (bad) find_bad(step, remove);
  return bad_rows_;
}

template <class T>
void Solver<T>::find_bad(std::int64_t step, bool remove) {
  static constexpr const char* names[9] = {
      "position.x", "position.y",         "position.z",         "velocity.x",        "velocity.y",
      "velocity.z", "angular_velocity.x", "angular_velocity.y", "angular_velocity.z"};
  for (std::size_t row = 0; row < rows_; ++row) {
    if (!lives(row)) continue;
    Place& place = places_[0][row];
    Motion& motion = motions_[0][row];
    for (std::size_t c = 0; c < 9; ++c) {
      const T* numbers = c < 3 ? place.position : c < 6 ? motion.velocity : motion.spin;
      const T value = numbers[c % 3];
      const bool outside = setup_.domain.bounded && c < 3 &&
                           (value < static_cast<T>(setup_.domain.lowest[c]) ||
                            value > static_cast<T>(setup_.domain.highest[c]));
      if (std::isfinite(value) && !outside) continue;
      bad_rows_.push_back(
          {ids_[rank_[row]], step + 1, names[c], static_cast<double>(value), std::isfinite(value)});
      if (remove) {
        place = nowhere();
        motion = at_rest();
        if (has_death_) death_[row] = static_cast<std::int32_t>(step + 1);
      }
      break;
    }
  }
  std::stable_sort(bad_rows_.begin(), bad_rows_.end(),
                   [](const BadRow& a, const BadRow& b) {  // exact-set: ids are unique
                     return a.id < b.id;
                   });
}

template <class T>
void Solver<T>::build_lists() {
  {
    const Stopwatch watch(profile_.list_seconds);
    memory_.collect(lists_.inner(), wall_lists_, rank_);
  }
  outer_path_ += longest_path_;
  const Margins wanted = margins();
  const bool reached = listed_ && outer_path_ < covered * (outer_margin_ - wanted.inner);
  listed_ = false;  // should there be no memory for the new ones
  if (reached) {
    const Stopwatch watch(profile_.list_seconds);
    margin_ = wanted.inner;
    forget_paths();
  } else {
    memory_.release_listed();
    sort_rows();
  }
  const Stopwatch watch(profile_.list_seconds);
  if (!reached && outer_margin_ <= margin_) {
    lists_.take_outer();
    outer_path_ = std::numeric_limits<double>::infinity();  // nothing is left to be pruned
  } else {
    lists_.prune(places_[0].data(), margin_ + rounding_);
  }
  find_wall_parts([this](std::size_t row) { return sight(row); }, rows_, walls_,
                  margin_ + rounding_, parallel_, wall_lists_);
  wall_lists_.make_room(law());
  memory_.recall(lists_.inner(), wall_lists_, rank_);
  listed_ = true;
  longest_path_ = 0;
  wall_path_ = 0;
  list_age_ = 0;
  ++profile_.list_builds;
  profile_.list_entries += lists_.inner_entries();
  profile_.list_slots += lists_.inner().slots() * group_rows;
}

template <class T>
void Solver<T>::sort_rows() {
  const auto see = [this](std::size_t row) { return sight(row); };
  {
    const Stopwatch watch(profile_.sort_seconds);
    lists_.look(rows_, see);
    extent_ = lists_.extent();
    // In single precision two may touch that are a little apart.
    if (sizeof(T) == 4) rounding_ = 0x1p-20 * extent_.largest_radius + 0x1p-44 * extent_.farthest;
    const Margins wanted = margins();
    margin_ = wanted.inner;
    outer_margin_ = wanted.outer;
    lists_.sort(outer_margin_ + rounding_, tuning_.cell_scale);
  }
  {
    const Stopwatch watch(profile_.list_seconds);
    lists_.look_in_order(see);
    // Where the next state goes, nobody looks before it is there.
    lists_.build(outer_margin_ + rounding_, rank_.data(),
                 {std::as_writable_bytes(std::span(places_[1].data(), rows_)),
                  std::as_writable_bytes(std::span(motions_[1].data(), rows_))});
  }
  const Stopwatch watch(profile_.sort_seconds);
  move_rows();
  outer_path_ = 0;
  ++profile_.sorts;
}

// Wide margins make long lists, narrow ones many: what a step takes grows with the margin m, and
// what making lists takes falls with m over the way s of a step, so that the least of both together
// is at an m that goes with the root of s. The factors were found by trying; the least is flat. In
// mean radii. Outer lists are worth their while where little is gone in a step, and are too long
// beyond a radius; far from the origin, single precision does not see much less than they hold.
template <class T>
typename Solver<T>::Margins Solver<T>::margins() const {
  constexpr double widest = 1;
  constexpr double narrowest = 0.01;
  constexpr double at_first = 0.003;
  const double radius = extent_.mean_radius;
  const auto root_of = [&](double path) {
    const double way = list_age_ > 0 ? path / static_cast<double>(list_age_) / radius : at_first;
    return sqrt(kernels::ScalarLane<double>(way)).value();
  };
  const double root = root_of(longest_path_ + wall_path_);
  const double blur = sizeof(T) == 4 ? 0x1p-21 * 3 * extent_.farthest / radius : 0;
  const double most = widest / 2.5;
  const bool pruned = 3.6 * root_of(longest_path_) < most && blur < 0.1;
  Margins m;
  m.inner = radius * (pruned ? std::clamp(3.6 * root, narrowest, most)
                             : std::clamp(6.7 * root, narrowest, widest));
  if (tuning_.margin > 0) m.inner = tuning_.margin;
  m.outer = pruned ? std::max(m.inner, std::min(4 * m.inner, widest * radius)) : m.inner;
  if (tuning_.outer_margins > 0) m.outer = std::max(tuning_.outer_margins, 1.0) * m.inner;
  return m;
}

template <class T>
void Solver<T>::move_rows() {
  for_rows([&](std::size_t first, std::size_t last) {
    for (std::size_t row = first; row < last; ++row) {
      const std::size_t source = lists_.source()[row];
      places_[1][row] = places_[0][source];
      motions_[1][row] = motions_[0][source];
      motions_[1][row].path = 0;
    }
  });
  places_[0].swap(places_[1]);
  motions_[0].swap(motions_[1]);
  lists_.take_rank(rank_);
  const auto move = [this](auto& column, auto& room) {
    permute(parallel_, rows_, lists_.source(), column, room);
  };
  if (has_drag_area_) move(drag_area_, moved_);
  if (has_death_) move(death_, moved_steps_);
  if (law().energy_budget) {
    for (auto& sums : budget_) move(sums, moved_);
  }
  memory_.move_rows(lists_.source());
}

template <class T>
void Solver<T>::forget_paths() {
  for_rows([&](std::size_t first, std::size_t last) {
    for (std::size_t row = first; row < last; ++row) motions_[0][row].path = 0;
  });
}

template <class T>
void Solver<T>::store(soa::Table& particles, soa::Table& contacts) {
  const Stopwatch watch(profile_.transfer_seconds);
  // Whoever looks needs room of their own.
  places_[1].release();
  motions_[1].release();
  lists_.release_outer();
  outer_path_ = std::numeric_limits<double>::infinity();
  memory_.collect(lists_.inner(), wall_lists_, rank_);
  for (const ParticleField field : stepped_fields) particles.restore(index(field));
  const auto column = [&](ParticleField field, std::size_t c = 0) {
    return particles.column<T>(index(field), c);
  };
  std::array<T*, budget_columns.size()> budget{};
  for (std::size_t i = 0; i < budget.size(); ++i) {
    budget[i] = column(budget_columns[i].field, budget_columns[i].component);
  }
  auto* death = particles.column<std::int32_t>(index(ParticleField::death));
  std::vector<std::uint32_t> row_of(particles_);
  std::vector<std::uint8_t> alive(particles_);
  for_rows([&](std::size_t first, std::size_t last) {
    for (std::size_t row = first; row < last; ++row) {
      const std::size_t rank = rank_[row];
      if (rank >= particles_) continue;
      row_of[rank] = static_cast<std::uint32_t>(row);
      alive[rank] = lives(row) ? 1 : 0;
      const Place& place = places_[0][row];
      const Motion& motion = motions_[0][row];
      const auto write = [&](ParticleField field, const T* from) {
        for (std::size_t c = 0; c < 3; ++c) {
          if (T* to = column(field, c)) to[rank] = from[c];
        }
      };
      write(ParticleField::position, place.position);
      write(ParticleField::residual, motion.residual);
      write(ParticleField::velocity, motion.velocity);
      write(ParticleField::angular_velocity, motion.spin);
      for (std::size_t i = 0; i < budget.size(); ++i) {
        if (budget[i]) budget[i][rank] = budget_[i][row];
      }
      if (death) death[rank] = death_[row];
    }
  });
  contacts = empty_contacts(setup_);
  if (law().remembers()) {
    memory_.store({ids_, particles_}, row_of, alive, contacts);
  }
  if (listed_) memory_.release_collected();
}

}  // namespace

std::unique_ptr<ContactSolver> make_contact_solver(const Setup& setup, Isa isa,
                                                   const ContactTuning& tuning,
                                                   const Parallel& parallel) {
  if (setup.precision == soa::Precision::float32) {
    return std::make_unique<Solver<float>>(setup, isa, tuning, parallel);
  }
  return std::make_unique<Solver<double>>(setup, isa, tuning, parallel);
}

void release_stored(soa::Table& particles) {
  for (const ParticleField field : stepped_fields) particles.release(index(field));
}

bool remembers_contacts(const Setup& setup) {
  return setup.contact_law && setup.contact_law->remembers();
}

namespace {

// Measured in piles at rest and in free fall.
constexpr std::uint64_t typical_slots = 2 * 15;  // outer lists, as they are found and laid out
constexpr std::uint64_t typical_contacts = 6;

// What one contact remembers, seen from one side.
std::uint64_t memory_bytes(const Setup& setup) {
  if (!remembers_contacts(setup)) return 0;
  return (setup.contact_law->rolls() ? 6 : 3) * size_of(soa::Scalar::real, setup.precision);
}

}  // namespace

std::uint64_t contact_solver_bytes(const Setup& setup, std::uint64_t particles) {
  const std::vector<bool> stored = World::stored_fields(setup);
  std::uint64_t row = setup.precision == soa::Precision::float32
                          ? 2 * (sizeof(SpherePlace<float>) + sizeof(SphereMotion<float>))
                          : 2 * (sizeof(SpherePlace<double>) + sizeof(SphereMotion<double>));
  row += 3 * sizeof(std::uint32_t);  // ranks and sources
  // First where the broad phase looks, and cells; then, when those are gone, lists.
  constexpr std::uint64_t searched =
      4 * sizeof(double) + 2 * (sizeof(std::uint64_t) + 3 * sizeof(std::uint32_t));
  row += std::max(searched, typical_slots * sizeof(std::int32_t));
  for (std::size_t f = 0; f < stored.size(); ++f) {
    const bool copied = f == index(ParticleField::drag_area) || f == index(ParticleField::death) ||
                        soa::only_of_budgets(f);
    const soa::Field& field = soa::particle_fields[f];
    if (stored[f] && copied) row += field.components * size_of(field.scalar, setup.precision);
  }
  const std::uint64_t memory = memory_bytes(setup);
  // In the lists, and while they are built also apart from them.
  if (memory > 0) {
    row += typical_contacts * (2 * memory + sizeof(std::uint32_t)) + 4 * sizeof(std::uint32_t);
  }
  row += row / 16;  // what the arrays keep to spare
  return particles * row;
}

std::uint64_t contact_table_bytes(const Setup& setup, std::uint64_t particles) {
  if (!remembers_contacts(setup)) return 0;
  return particles * typical_contacts / 2 * (2 * sizeof(std::uint64_t) + memory_bytes(setup));
}

soa::Table empty_contacts(const Setup& setup) {
  const bool frictional = remembers_contacts(setup);
  const bool rolls = frictional && setup.contact_law->rolls();
  return {soa::contact_fields, setup.precision, {true, true, frictional, rolls}};
}

}  // namespace salvo::solver
