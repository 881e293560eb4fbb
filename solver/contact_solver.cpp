#include "solver/contact_solver.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "kernels/sphere_contact.hpp"
#include "models/particle.hpp"
#include "soa/contact_fields.hpp"
#include "soa/particle_fields.hpp"
#include "solver/instants.hpp"
#include "solver/walls.hpp"
#include "solver/world.hpp"

namespace salvo::solver {

namespace {

using soa::ContactField;
using soa::ParticleField;

template <class Field>
constexpr std::size_t index(Field field) {
  return static_cast<std::size_t>(field);
}

constexpr std::size_t groups_per_task = 64;
constexpr std::size_t rows_per_task = groups_per_task * group_rows;
// Rows of a window are ordered by the length of their lists, so that a group fills up little.
constexpr std::size_t window_rows = 128;
constexpr std::size_t listed_rows = 32 * window_rows;  // of a task
constexpr std::size_t length_classes = 256;

constexpr std::uint32_t wall_flag = std::uint32_t{1} << 31;

std::size_t tasks_of(std::size_t things, std::size_t each) { return (things + each - 1) / each; }

// The longer a list, the lower; from 32 entries on, lists of about the same length have one number.
std::size_t length_class(std::uint32_t entries) {
  constexpr std::size_t exact = 32;
  if (entries < exact) return length_classes - 1 - entries;
  const auto digits = static_cast<std::size_t>(std::bit_width(entries));
  return length_classes - 1 - (exact + (digits - 6) * 8 + (entries >> (digits - 4) & 7));
}

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

// A zero-filled array that keeps its room.
template <class T>
class Array {
 public:
  void resize(std::size_t size) {
    if (size * sizeof(T) > bytes_.size()) {
      bytes_ = {};
      bytes_ = soa::AlignedBytes(size * sizeof(T) + size * sizeof(T) / 16);
    }
    size_ = size;
  }
  T* data() { return reinterpret_cast<T*>(bytes_.data()); }
  const T* data() const { return reinterpret_cast<const T*>(bytes_.data()); }
  T& operator[](std::size_t i) { return data()[i]; }
  const T& operator[](std::size_t i) const { return data()[i]; }
  std::size_t size() const { return size_; }
  std::size_t resident_bytes() const { return bytes_.size(); }
  void swap(Array& other) noexcept {
    std::swap(bytes_, other.bytes_);
    std::swap(size_, other.size_);
  }
  void release() {
    bytes_ = {};
    size_ = 0;
  }

 private:
  soa::AlignedBytes bytes_;
  std::size_t size_ = 0;
};

// What the contacts of every row remember, apart from the lists: partners in ascending order, ranks
// of particles before walls. It outlives the lists, and is what checkpoints keep.
template <class T>
struct Remembered {
  Array<std::uint32_t> first;    // of each row, and their number
  Array<std::uint32_t> partner;  // rank, or wall_flag | wall
  Array<T> tangential;           // three for each
  Array<T> rolling;

  void resize_entries(std::size_t entries, const models::ContactLaw& law) {
    partner.resize(entries);
    if (law.remembers()) tangential.resize(3 * entries);
    if (law.rolls()) rolling.resize(3 * entries);
  }
  std::size_t resident_bytes() const {
    return first.resident_bytes() + partner.resident_bytes() + tangential.resident_bytes() +
           rolling.resident_bytes();
  }
};

// Numbers that a contact remembers.
std::size_t history_columns(const models::ContactLaw& law) {
  return law.rolls() ? 6 : law.remembers() ? 3 : 0;
}

// What the contacts of one task remember, as columns in the order of the slots and lanes.
template <class T>
struct TaskHistory {
  std::vector<T> numbers;
  std::size_t contacts = 0;

  void resize(std::size_t count, std::size_t columns) {
    if (count * columns > numbers.capacity()) {
      numbers = {};
      numbers.reserve(columns * (count + count / 8 + 1));
    }
    numbers.resize(columns * count);
    contacts = count;
  }
};

// Lists of particles.
template <class T>
struct NeighborLists {
  Array<std::uint64_t> first_slot;  // of each group, and their number
  Array<std::uint16_t> touching;
  std::vector<TaskHistory<T>> history;

  std::size_t slots() const {
    return first_slot.size() == 0 ? 0 : first_slot[first_slot.size() - 1];
  }
  void make_room(const models::ContactLaw& law) {
    touching.resize(slots());
    if (law.remembers()) history.resize(tasks_of(first_slot.size() - 1, groups_per_task));
  }
  std::size_t resident_bytes() const {
    std::size_t bytes = first_slot.resident_bytes() + touching.resident_bytes();
    for (const auto& task : history) bytes += task.numbers.capacity() * sizeof(T);
    return bytes;
  }
};

// Lists of walls.
template <class T>
struct WallLists {
  Array<std::uint64_t> first_slot;  // of each group, and their number
  Array<std::uint16_t> touching;
  Array<T> tangential;
  Array<T> rolling;

  void make_room(std::size_t slots, const models::ContactLaw& law) {
    touching.resize(slots);
    const std::size_t numbers = slots * 3 * group_rows;
    if (law.remembers()) tangential.resize(numbers);
    if (law.rolls()) rolling.resize(numbers);
  }
  // The kernel reads the slot of all lanes when one of them touched.
  void clear_slot(std::size_t slot, const models::ContactLaw& law) {
    constexpr std::size_t numbers = 3 * group_rows;
    const auto clear = [&](Array<T>& column) {
      std::fill_n(column.data() + slot * numbers, numbers, T(0));
    };
    if (law.remembers()) clear(tangential);
    if (law.rolls()) clear(rolling);
  }
  WallMemory<T> memory() { return {touching.data(), tangential.data(), rolling.data()}; }
  std::size_t resident_bytes() const {
    return first_slot.resident_bytes() + touching.resident_bytes() + tangential.resident_bytes() +
           rolling.resident_bytes();
  }
};

template <class T>
class Solver final : public ContactSolver {
 public:
  Solver(const Setup& setup, Isa isa, const ContactTuning& tuning, const Parallel& parallel)
      : setup_(setup),
        kernels_(contact_kernels(isa)),
        tuning_(tuning),
        parallel_(parallel),
        walls_(setup.obstacles) {
    damping_ratio_ = kernels::damping_ratio_of(setup.contact_law->restitution);
  }

  void load(const soa::Table& particles, const soa::Table& contacts) override;
  std::span<const BadRow> advance(std::int64_t step, bool watch_deaths, bool remove) override;
  std::int64_t next_death(std::int64_t after) const override;
  void store(soa::Table& particles, soa::Table& contacts) override;
  std::size_t resident_bytes() const override;

 private:
  using Place = SpherePlace<T>;
  using Motion = SphereMotion<T>;
  const models::ContactLaw& law() const { return *setup_.contact_law; }

  template <class Task>
  void for_rows(const Task& task) const {
    parallel_.for_each(tasks_of(rows_, rows_per_task), [&](std::size_t number) {
      const std::size_t first = number * rows_per_task;
      task(first, std::min(rows_, first + rows_per_task));
    });
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
  std::array<double, 3> position(std::size_t row) const {
    std::array<double, 3> at;
    for (std::size_t c = 0; c < 3; ++c) {
      at[c] = static_cast<double>(places_[0][row].position[c]) +
              static_cast<double>(motions_[0][row].residual[c]);
    }
    return at;
  }

  // Where a row comes to lie, and its place by id.
  struct NewPlace {
    std::uint32_t row;
    std::uint32_t rank;
  };
  // Room for the lists of a task, until motions_[1] is written.
  struct RawLists {
    std::span<std::uint32_t> room;
    std::vector<std::uint32_t>* more;
    std::uint32_t* data() const { return more->empty() ? room.data() : more->data(); }
  };
  RawLists raw_lists(std::size_t task) {
    const std::size_t first = task * listed_rows;
    const std::size_t bytes = (std::min(rows_, first + listed_rows) - first) * sizeof(Motion);
    return {{reinterpret_cast<std::uint32_t*>(motions_[1].data() + first),
             bytes / sizeof(std::uint32_t)},
            &long_lists_[task]};
  }
  void build_lists();
  void choose_margin();
  void search_columns(const std::vector<std::uint32_t>* order);
  void list_rows();
  void place_rows();
  void lay_out_neighbors();
  void lay_out_row(const std::uint32_t* raw, std::size_t count, std::int32_t* to, std::size_t slots,
                   std::vector<NewPlace>& list) const;
  void lay_out_walls();
  void move_rows();
  void collect();
  void recall();
  void recall_row(std::size_t group, std::size_t lane, std::uint32_t* entries);
  // Calls visit(slot, lane) for the contacts of a group, slots ascending.
  template <class Visit>
  void for_contacts(std::size_t group, const Visit& visit) const;
  template <class Visit>
  void for_wall_contacts(std::size_t group, const Visit& visit) const;
  void find_bad(std::int64_t step, bool remove);
  template <class Number>
  void permute(Array<Number>& column, Number padding);

  const Setup& setup_;
  const ContactKernels& kernels_;
  const ContactTuning tuning_;
  const Parallel& parallel_;
  Walls walls_;
  double damping_ratio_;

  std::size_t rows_ = 0;  // groups are whole: those after the particles are nowhere
  std::size_t particles_ = 0;
  const soa::Id* ids_ = nullptr;  // by rank
  Array<Place> places_[2];        // the state, and where the next one goes
  Array<Motion> motions_[2];
  Array<std::uint32_t> rank_;  // place by id of each row
  Array<T> drag_area_;
  Array<std::int32_t> death_;
  Array<T> damping_loss_;
  Array<T> friction_loss_;
  Array<T> approaches_;
  T uniform_drag_area_ = 0;
  bool equal_ = false;  // of mass and radius
  T uniform_mass_ = 1;
  T uniform_radius_ = 0;
  bool has_drag_area_ = false;
  bool has_death_ = false;

  bool listed_ = false;
  double margin_ = 0;
  double wall_path_ = 0;       // m, of the walls since the lists were built
  double longest_path_ = 0;    // m, of the particles
  std::int64_t list_age_ = 0;  // steps
  NeighborLists<T> near_;
  Array<std::int32_t> neighbor_;
  WallLists<T> wall_lists_;
  Array<std::uint32_t> wall_;
  Remembered<T> remembered_;
  bool remembering_ = false;  // the lists' memory is in remembered_

  // Of the building of lists.
  CellGrid grid_;
  Array<double> search_[4];
  Array<std::uint32_t> source_;  // old row of each new row
  Array<NewPlace> place_;        // new row of each row in the order of the cells
  Array<std::uint32_t> new_rank_;
  // Lists of each task, rows in the order of the cells, lie where the next state goes; these are
  // those that are too long for that.
  std::vector<std::vector<std::uint32_t>> long_lists_;
  Array<std::uint32_t> raw_count_;
  Array<std::uint32_t> raw_first_;  // within its task

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
  const T* damping_loss = column(ParticleField::damping_loss);
  const T* friction_loss = column(ParticleField::friction_loss);
  has_drag_area_ = drag_area != nullptr;
  has_death_ = death != nullptr;
  uniform_drag_area_ = uniform(ParticleField::drag_area);
  equal_ = mass == nullptr && radius == nullptr;
  uniform_mass_ = uniform(ParticleField::mass);
  uniform_radius_ = uniform(ParticleField::radius);
  for (std::size_t n : {0, 1}) {
    places_[n].resize(rows_ + 1);
    motions_[n].resize(rows_ + 1);
    places_[n][rows_] = nowhere();
    motions_[n][rows_] = at_rest();
  }
  rank_.resize(rows_);
  if (has_drag_area_) drag_area_.resize(rows_);
  if (has_death_) death_.resize(rows_);
  if (damping_loss) damping_loss_.resize(rows_);
  if (friction_loss) friction_loss_.resize(rows_);
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
      if (damping_loss) damping_loss_[row] = real ? damping_loss[row] : T(0);
      if (friction_loss) friction_loss_[row] = real ? friction_loss[row] : T(0);
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

  // Both sides of every contact, in the order of the ids.
  const std::size_t pairs = contacts.rows();
  const soa::Id* id = contacts.ids();
  const auto* partner = contacts.column<std::uint64_t>(index(ContactField::partner));
  const auto rank_of = [&](soa::Id wanted) {
    return static_cast<std::uint32_t>(std::lower_bound(ids_, ids_ + particles_, wanted) - ids_);
  };
  std::vector<std::array<std::uint32_t, 2>> sides(pairs);
  Remembered<T>& r = remembered_;
  r.first.resize(rows_ + 1);
  std::fill(r.first.data(), r.first.data() + rows_ + 1, 0U);
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    const bool wall = soa::stream_of(partner[pair]) == soa::max_stream;
    sides[pair] = {rank_of(id[pair]),
                   wall ? wall_flag | static_cast<std::uint32_t>(soa::serial_of(partner[pair]))
                        : rank_of(partner[pair])};
    ++r.first[sides[pair][0]];
    if (!wall) ++r.first[sides[pair][1]];
  }
  std::uint32_t entries = 0;
  for (std::size_t row = 0; row <= rows_; ++row) entries += std::exchange(r.first[row], entries);
  r.resize_entries(entries, law());
  std::vector<std::uint32_t> next(r.first.data(), r.first.data() + rows_);
  const auto add = [&](std::uint32_t row, std::uint32_t other, std::size_t pair, T sign, T same) {
    const std::uint32_t entry = next[row]++;
    r.partner[entry] = other;
    for (std::size_t c = 0; c < 3; ++c) {
      if (law().remembers()) {
        r.tangential[3 * entry + c] =
            sign * contacts.column<T>(index(ContactField::tangential_displacement), c)[pair];
      }
      if (law().rolls()) {
        r.rolling[3 * entry + c] =
            same * contacts.column<T>(index(ContactField::rolling_displacement), c)[pair];
      }
    }
  };
  // The higher sides first: a row's partners of lower id come before those of higher id.
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    if ((sides[pair][1] & wall_flag) == 0) add(sides[pair][1], sides[pair][0], pair, T(-1), T(1));
  }
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    add(sides[pair][0], sides[pair][1], pair, T(1), T(1));
  }
  remembering_ = true;
  listed_ = false;
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
  // A path is a sum of rounded lengths; a thousandth covers what it may be short of.
  constexpr double covered = 0.499;
  walls_.place(setup_.t0 + static_cast<double>(step) * setup_.dt);
  if (!listed_ || longest_path_ + wall_path_ > covered * margin_ ||
      (tuning_.list_interval > 0 && list_age_ >= tuning_.list_interval)) {
    build_lists();
  }
  const Stopwatch watch(profile_.step_seconds);
  instant_coefficients(setup_.forces, setup_.seed, setup_.t0, setup_.dt, step, 1, instants_);
  ContactPass<T> whole;
  whole.from = {places_[0].data(), motions_[0].data()};
  whole.to = {places_[1].data(), motions_[1].data()};
  whole.first_slot = near_.first_slot.data();
  whole.neighbor = neighbor_.data();
  whole.first_wall_slot = wall_lists_.first_slot.data();
  whole.wall_part = wall_.data();
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
    whole.damping_loss = damping_loss_.data();
    whole.friction_loss = friction_loss_.data();
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
  const std::size_t columns = history_columns(law());
  parallel_.for_each(tasks, [&](std::size_t task) {
    ContactPass<T> pass = part(task);
    // What the contacts remember afterwards: as many as there are neighbors, at most.
    thread_local std::vector<T> after;
    if (columns > 0) {
      const TaskHistory<T>& before = near_.history[task];
      const std::size_t slots =
          near_.first_slot[pass.last_group] - near_.first_slot[pass.first_group];
      pass.history.touching = near_.touching.data();
      pass.history.before = before.numbers.data();
      pass.history.count_before = before.contacts;
      pass.history.room = slots * group_rows;
      if (after.size() < columns * pass.history.room) after.resize(columns * pass.history.room);
      pass.history.after = after.data();
    }
    if constexpr (sizeof(T) == 4) {
      kernels_.advance_float32(pass);
    } else {
      kernels_.advance_float64(pass);
    }
    if (columns > 0) {
      TaskHistory<T>& history = near_.history[task];
      history.resize(pass.history.count, columns);
      for (std::size_t c = 0; c < columns; ++c) {
        std::copy_n(after.data() + c * pass.history.room, pass.history.count,
                    history.numbers.data() + c * pass.history.count);
      }
    }
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

// ---- lists --------------------------------------------------------------------------------------

template <class T>
void Solver<T>::build_lists() {
  {
    const Stopwatch watch(profile_.sort_seconds);
    if (!remembering_) collect();
    search_columns(nullptr);
    choose_margin();
    grid_.build({search_[0].data(), search_[1].data(), search_[2].data(), search_[3].data()}, rows_,
                margin_, tuning_.cell_scale, parallel_);
  }
  {
    const Stopwatch watch(profile_.list_seconds);
    search_columns(&grid_.order());
    list_rows();
    place_rows();
    lay_out_neighbors();
    lay_out_walls();
    recall();
  }
  {
    const Stopwatch watch(profile_.sort_seconds);
    move_rows();
  }
  remembering_ = false;
  listed_ = true;
  longest_path_ = 0;
  wall_path_ = 0;
  list_age_ = 0;
  ++profile_.list_builds;
  profile_.list_slots += near_.slots() * group_rows;
}

// Wide margins make long lists, narrow ones many: about twenty steps a list is near the optimum and
// flat around it.
template <class T>
void Solver<T>::choose_margin() {
  if (tuning_.margin > 0) {
    margin_ = tuning_.margin;
    return;
  }
  struct Part {
    double sum = 0;
    std::size_t alive = 0;
  };
  std::vector<Part> parts(tasks_of(rows_, rows_per_task));
  for_rows([&](std::size_t first, std::size_t last) {
    Part& part = parts[first / rows_per_task];
    for (std::size_t row = first; row < last; ++row) {
      const double radius = search_[3][row];
      part.sum += std::max(radius, 0.0);
      part.alive += radius > 0 ? 1 : 0;
    }
  });
  double sum = 0;
  std::size_t alive = 0;
  for (const Part& part : parts) {
    sum += part.sum;
    alive += part.alive;
  }
  const double mean_radius = alive == 0 ? 1 : sum / static_cast<double>(alive);
  if (margin_ == 0) margin_ = 0.2 * mean_radius;
  if (listed_ && list_age_ < 10) margin_ *= 1.5;
  if (listed_ && list_age_ > 60) margin_ *= 0.7;
  margin_ = std::clamp(margin_, 0.02 * mean_radius, mean_radius);
}

// Positions in double precision, in the order of the rows or of the cells.
template <class T>
void Solver<T>::search_columns(const std::vector<std::uint32_t>* order) {
  for (auto& column : search_) column.resize(rows_ + group_rows);
  for_rows([&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const std::size_t row = order ? (*order)[i] : i;
      const std::array<double, 3> at = position(row);
      for (std::size_t c = 0; c < 3; ++c) search_[c][i] = at[c];
      search_[3][i] = lives(row) ? static_cast<double>(places_[0][row].radius) : -1.0;
    }
  });
}

template <class T>
void Solver<T>::list_rows() {
  const std::size_t members = grid_.members();
  const std::size_t tasks = tasks_of(rows_, listed_rows);
  long_lists_.clear();
  long_lists_.resize(tasks);
  raw_count_.resize(rows_);
  raw_first_.resize(rows_);
  parallel_.for_each(tasks, [&](std::size_t task) {
    ListPass pass;
    pass.first_row = std::min(members, task * listed_rows);
    pass.last_row = std::min(members, pass.first_row + listed_rows);
    pass.index = grid_.index();
    pass.columns = {search_[0].data(), search_[1].data(), search_[2].data(), search_[3].data()};
    pass.margin = margin_;
    RawLists lists = raw_lists(task);
    pass.owner = &lists;
    pass.grow = [](void* owner, std::size_t entries) {
      const RawLists& own = *static_cast<RawLists*>(owner);
      if (entries > own.room.size() && entries > own.more->size()) {
        const bool moves = own.more->empty();
        own.more->resize(entries);
        if (moves) std::copy(own.room.begin(), own.room.end(), own.more->begin());
      }
      return own.data();
    };
    pass.counts = raw_count_.data() + pass.first_row;
    kernels_.list_neighbors(pass);
    std::uint32_t first = 0;
    for (std::size_t row = task * listed_rows; row < std::min(rows_, (task + 1) * listed_rows);
         ++row) {
      if (row >= members) raw_count_[row] = 0;
      raw_first_[row] = first;
      first += raw_count_[row];
    }
  });
}

// Orders the rows of each window by the length of their lists, the longest first, and counts the
// slots that each group needs.
template <class T>
void Solver<T>::place_rows() {
  const std::size_t groups = rows_ / group_rows;
  source_.resize(rows_);
  new_rank_.resize(rows_);
  place_.resize(rows_);
  near_.first_slot.resize(groups + 1);
  const std::size_t tasks = tasks_of(rows_, listed_rows);
  std::vector<std::uint64_t> entries(tasks);
  parallel_.for_each(tasks, [&](std::size_t task) {
    const std::size_t end = std::min(rows_, (task + 1) * listed_rows);
    for (std::size_t first = task * listed_rows; first < end; first += window_rows) {
      const std::size_t last = std::min(end, first + window_rows);
      std::array<std::uint32_t, length_classes> next{};
      for (std::size_t i = first; i < last; ++i) ++next[length_class(raw_count_[i])];
      auto row = static_cast<std::uint32_t>(first);
      for (std::uint32_t& n : next) row += std::exchange(n, row);
      std::array<std::uint32_t, window_rows / group_rows> longest{};
      for (std::size_t i = first; i < last; ++i) {
        const std::uint32_t count = raw_count_[i];
        const std::uint32_t place = next[length_class(count)]++;
        const std::uint32_t source = grid_.order()[i];
        source_[place] = source;
        new_rank_[place] = rank_[source];
        place_[i] = {place, rank_[source]};
        std::uint32_t& most = longest[(place - first) / group_rows];
        most = std::max(most, count);
        entries[task] += count;
      }
      for (std::size_t n = 0; n < (last - first) / group_rows; ++n) {
        near_.first_slot[first / group_rows + n] = longest[n];
      }
    }
  });
  std::uint64_t slots = 0;
  for (std::size_t group = 0; group < groups; ++group) {
    slots += std::exchange(near_.first_slot[group], slots);
  }
  near_.first_slot[groups] = slots;
  for (const std::uint64_t n : entries) profile_.list_entries += n;
}

template <class T>
void Solver<T>::lay_out_neighbors() {
  near_.make_room(law());
  neighbor_.resize(near_.slots() * group_rows);
  parallel_.for_each(tasks_of(rows_, listed_rows), [&](std::size_t task) {
    std::vector<NewPlace> list;
    const std::uint32_t* raw = raw_lists(task).data();
    const std::size_t end = std::min(rows_, (task + 1) * listed_rows);
    for (std::size_t first = task * listed_rows; first < end; first += window_rows) {
      const std::size_t last = std::min(end, first + window_rows);
      // Rows of like length follow one another.
      std::array<std::uint32_t, window_rows> among_cells;
      for (std::size_t i = first; i < last; ++i) {
        among_cells[place_[i].row - first] = static_cast<std::uint32_t>(i);
      }
      for (std::size_t row = first; row < last; ++row) {
        const std::size_t i = among_cells[row - first];
        const std::size_t group = row / group_rows;
        const std::uint64_t first_slot = near_.first_slot[group];
        lay_out_row(raw + raw_first_[i], raw_count_[i],
                    neighbor_.data() + first_slot * group_rows + row % group_rows,
                    near_.first_slot[group + 1] - first_slot, list);
      }
      std::fill(near_.touching.data() + near_.first_slot[first / group_rows],
                near_.touching.data() + near_.first_slot[last / group_rows], std::uint16_t{0});
    }
  });
  long_lists_ = {};
}

// Writes the list of one row by ascending rank. For each of a short list the smaller ones are
// counted, without a branch that would go either way.
template <class T>
void Solver<T>::lay_out_row(const std::uint32_t* raw, std::size_t count, std::int32_t* to,
                            std::size_t slots, std::vector<NewPlace>& list) const {
  constexpr std::size_t few = 24;
  constexpr std::size_t step = 4;  // the widest that every processor has
  using Ranks [[gnu::vector_size(step * sizeof(std::int32_t))]] = std::int32_t;
  if (count <= few) {
    std::array<std::int32_t, few> row;
    alignas(Ranks) std::array<std::int32_t, few> rank;
    for (std::size_t n = 0; n < count; ++n) {
      const NewPlace place = place_[raw[n]];
      row[n] = static_cast<std::int32_t>(place.row);
      rank[n] = static_cast<std::int32_t>(place.rank);
    }
    for (std::size_t first = 0; first < count; first += step) {
      Ranks some;
      std::memcpy(&some, rank.data() + first, sizeof(some));
      Ranks lower{};
      for (std::size_t n = 0; n < count; ++n) lower -= rank[n] < some;
      const std::size_t last = std::min(count, first + step);
      for (std::size_t n = first; n < last; ++n) {
        to[static_cast<std::size_t>(lower[n - first]) * group_rows] = row[n];
      }
    }
  } else {
    list.resize(count);
    for (std::size_t n = 0; n < count; ++n) list[n] = place_[raw[n]];
    std::sort(list.begin(), list.end(),  // exact-set: ranks are unique
              [](const NewPlace& a, const NewPlace& b) { return a.rank < b.rank; });
    for (std::size_t n = 0; n < count; ++n) {
      to[n * group_rows] = static_cast<std::int32_t>(list[n].row);
    }
  }
  for (std::size_t n = count; n < slots; ++n) {
    to[n * group_rows] = static_cast<std::int32_t>(rows_);
  }
}

// The walls that a group may reach before the lists are built again.
template <class T>
void Solver<T>::lay_out_walls() {
  const std::size_t groups = rows_ / group_rows;
  wall_lists_.first_slot.resize(groups + 1);
  std::vector<std::vector<std::uint32_t>> found(tasks_of(groups, groups_per_task));
  std::vector<std::uint32_t> counts(groups);
  parallel_.for_each(found.size(), [&](std::size_t task) {
    std::vector<std::uint32_t>& walls = found[task];
    const std::size_t end = std::min(rows_, (task + 1) * rows_per_task);
    for (std::size_t first = task * rows_per_task; first < end; first += window_rows) {
      const std::size_t last = std::min(end, first + window_rows);
      std::array<Bounds, window_rows / group_rows> bounds;
      for (std::size_t i = first; i < last; ++i) {
        if (!(search_[3][i] > 0)) continue;
        bounds[(place_[i].row - first) / group_rows].add(
            {search_[0][i], search_[1][i], search_[2][i]}, search_[3][i]);
      }
      for (std::size_t group = first / group_rows; group < last / group_rows; ++group) {
        const Bounds& of_group = bounds[group - first / group_rows];
        if (of_group.empty()) continue;
        const std::size_t before = walls.size();
        walls_.near(of_group, margin_, walls);
        counts[group] = static_cast<std::uint32_t>(walls.size() - before);
      }
    }
  });
  std::uint64_t slots = 0;
  for (std::size_t group = 0; group < groups; ++group) {
    wall_lists_.first_slot[group] = slots;
    slots += counts[group];
  }
  wall_lists_.first_slot[groups] = slots;
  wall_lists_.make_room(slots, law());
  wall_.resize(slots);
  std::uint32_t* to = wall_.data();
  for (const auto& walls : found) to = std::copy(walls.begin(), walls.end(), to);
  std::fill(wall_lists_.touching.data(), wall_lists_.touching.data() + slots, std::uint16_t{0});
}

template <class T>
template <class Number>
void Solver<T>::permute(Array<Number>& column, Number padding) {
  Array<Number> moved;
  moved.resize(column.size());
  for_rows([&](std::size_t first, std::size_t last) {
    for (std::size_t row = first; row < last; ++row) moved[row] = column[source_[row]];
  });
  if (column.size() > rows_) moved[rows_] = padding;
  column.swap(moved);
}

template <class T>
void Solver<T>::move_rows() {
  for_rows([&](std::size_t first, std::size_t last) {
    for (std::size_t row = first; row < last; ++row) {
      places_[1][row] = places_[0][source_[row]];
      motions_[1][row] = motions_[0][source_[row]];
      motions_[1][row].path = 0;
    }
  });
  places_[0].swap(places_[1]);
  motions_[0].swap(motions_[1]);
  rank_.swap(new_rank_);
  if (has_drag_area_) permute(drag_area_, T(0));
  if (has_death_) permute(death_, soa::never);
  if (law().energy_budget) {
    permute(damping_loss_, T(0));
    permute(friction_loss_, T(0));
  }
}

// ---- memory of the contacts ---------------------------------------------------------------------

template <class T>
template <class Visit>
void Solver<T>::for_contacts(std::size_t group, const Visit& visit) const {
  for (std::size_t slot = near_.first_slot[group]; slot < near_.first_slot[group + 1]; ++slot) {
    for (std::uint32_t left = near_.touching[slot]; left != 0; left &= left - 1) {
      visit(slot, static_cast<std::size_t>(std::countr_zero(left)));
    }
  }
}

template <class T>
template <class Visit>
void Solver<T>::for_wall_contacts(std::size_t group, const Visit& visit) const {
  for (std::size_t slot = wall_lists_.first_slot[group]; slot < wall_lists_.first_slot[group + 1];
       ++slot) {
    for (std::uint32_t left = wall_lists_.touching[slot]; left != 0; left &= left - 1) {
      visit(slot, static_cast<std::size_t>(std::countr_zero(left)));
    }
  }
}

// Moves the memory of the contacts out of the lists, in the order of the rows.
template <class T>
void Solver<T>::collect() {
  remembering_ = true;
  if (!law().remembers()) return;
  Remembered<T>& r = remembered_;
  r.first.resize(rows_ + 1);
  const std::size_t groups = rows_ / group_rows;
  const std::size_t tasks = tasks_of(groups, groups_per_task);
  parallel_.for_each(tasks, [&](std::size_t task) {
    for (std::size_t group = task * groups_per_task;
         group < std::min(groups, (task + 1) * groups_per_task); ++group) {
      std::uint32_t* counts = r.first.data() + group * group_rows;
      std::fill_n(counts, group_rows, 0U);
      const auto count = [&](std::size_t, std::size_t lane) { ++counts[lane]; };
      for_contacts(group, count);
      for_wall_contacts(group, count);
    }
  });
  std::uint32_t entries = 0;
  for (std::size_t row = 0; row < rows_; ++row) entries += std::exchange(r.first[row], entries);
  r.first[rows_] = entries;
  r.resize_entries(entries, law());
  parallel_.for_each(tasks, [&](std::size_t task) {
    const TaskHistory<T>& history = near_.history[task];
    std::size_t contact = 0;
    for (std::size_t group = task * groups_per_task;
         group < std::min(groups, (task + 1) * groups_per_task); ++group) {
      std::array<std::uint32_t, group_rows> next;
      std::copy_n(r.first.data() + group * group_rows, group_rows, next.data());
      for_contacts(group, [&](std::size_t slot, std::size_t lane) {
        const std::size_t entry = next[lane]++;
        r.partner[entry] = rank_[static_cast<std::size_t>(neighbor_[slot * group_rows + lane])];
        const T* from = history.numbers.data() + contact;
        for (std::size_t c = 0; c < 3; ++c) {
          r.tangential[3 * entry + c] = from[c * history.contacts];
          if (law().rolls()) r.rolling[3 * entry + c] = from[(3 + c) * history.contacts];
        }
        ++contact;
      });
      for_wall_contacts(group, [&](std::size_t slot, std::size_t lane) {
        const std::size_t entry = next[lane]++;
        r.partner[entry] = wall_flag | wall_[slot];
        for (std::size_t c = 0; c < 3; ++c) {
          const std::size_t from = (slot * 3 + c) * group_rows + lane;
          r.tangential[3 * entry + c] = wall_lists_.tangential[from];
          if (law().rolls()) r.rolling[3 * entry + c] = wall_lists_.rolling[from];
        }
      });
    }
  });
}

// Puts back into the new lists what the contacts remember. Lists and memories both ascend.
template <class T>
void Solver<T>::recall() {
  if (!law().remembers()) return;
  const std::size_t groups = rows_ / group_rows;
  parallel_.for_each(tasks_of(groups, groups_per_task), [&](std::size_t task) {
    constexpr std::uint32_t nobody = ~std::uint32_t{0};
    std::vector<std::uint32_t> entries;   // of what is remembered, by slot and lane
    std::vector<std::uint32_t> contacts;  // of the task, in the order of the slots
    for (std::size_t group = task * groups_per_task;
         group < std::min(groups, (task + 1) * groups_per_task); ++group) {
      const std::size_t first_slot = near_.first_slot[group];
      entries.assign((near_.first_slot[group + 1] - first_slot) * group_rows, nobody);
      for (std::size_t lane = 0; lane < group_rows; ++lane) {
        recall_row(group, lane, entries.data());
      }
      for_contacts(group, [&](std::size_t slot, std::size_t lane) {
        contacts.push_back(entries[(slot - first_slot) * group_rows + lane]);
      });
    }
    TaskHistory<T>& history = near_.history[task];
    history.resize(contacts.size(), history_columns(law()));
    for (std::size_t contact = 0; contact < contacts.size(); ++contact) {
      T* to = history.numbers.data() + contact;
      const std::size_t from = 3 * std::size_t{contacts[contact]};
      for (std::size_t c = 0; c < 3; ++c) {
        to[c * history.contacts] = remembered_.tangential[from + c];
        if (law().rolls()) to[(3 + c) * history.contacts] = remembered_.rolling[from + c];
      }
    }
  });
}

// Marks the contacts of a row in the lists and says which entry of what is remembered is whose.
template <class T>
void Solver<T>::recall_row(std::size_t group, std::size_t lane, std::uint32_t* entries) {
  const std::uint64_t first_slot = near_.first_slot[group];
  const std::uint64_t last_slot = near_.first_slot[group + 1];
  const std::uint64_t last_wall_slot = wall_lists_.first_slot[group + 1];
  std::uint64_t slot = first_slot;
  std::uint64_t wall_slot = wall_lists_.first_slot[group];
  const std::size_t source = source_[group * group_rows + lane];
  for (std::uint32_t entry = remembered_.first[source]; entry < remembered_.first[source + 1];
       ++entry) {
    const std::uint32_t partner = remembered_.partner[entry];
    const auto mark = [&](Array<std::uint16_t>& touching, std::uint64_t at) {
      touching[at] = static_cast<std::uint16_t>(touching[at] | 1U << lane);
    };
    if ((partner & wall_flag) == 0) {
      const auto rank_at = [&](std::uint64_t s) {
        const auto other = static_cast<std::size_t>(neighbor_[s * group_rows + lane]);
        return other == rows_ ? wall_flag : new_rank_[other];
      };
      while (slot < last_slot && rank_at(slot) < partner) ++slot;
      if (slot == last_slot || rank_at(slot) != partner) continue;
      mark(near_.touching, slot);
      entries[(slot - first_slot) * group_rows + lane] = entry;
    } else {
      const std::uint32_t wall = partner & ~wall_flag;
      while (wall_slot < last_wall_slot && wall_[wall_slot] < wall) ++wall_slot;
      if (wall_slot == last_wall_slot || wall_[wall_slot] != wall) continue;
      if (wall_lists_.touching[wall_slot] == 0) wall_lists_.clear_slot(wall_slot, law());
      mark(wall_lists_.touching, wall_slot);
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t to = (wall_slot * 3 + c) * group_rows + lane;
        wall_lists_.tangential[to] = remembered_.tangential[3 * entry + c];
        if (law().rolls()) wall_lists_.rolling[to] = remembered_.rolling[3 * entry + c];
      }
    }
  }
}

template <class T>
void Solver<T>::store(soa::Table& particles, soa::Table& contacts) {
  const Stopwatch watch(profile_.transfer_seconds);
  // Whoever looks needs room of their own.
  for (auto& column : search_) column.release();
  grid_.release();
  if (!remembering_) collect();
  const auto column = [&](ParticleField field, std::size_t c = 0) {
    return particles.column<T>(index(field), c);
  };
  T* damping_loss = column(ParticleField::damping_loss);
  T* friction_loss = column(ParticleField::friction_loss);
  auto* death = particles.column<std::int32_t>(index(ParticleField::death));
  std::vector<std::uint32_t> row_of(particles_);
  for_rows([&](std::size_t first, std::size_t last) {
    for (std::size_t row = first; row < last; ++row) {
      const std::size_t rank = rank_[row];
      if (rank >= particles_) continue;
      row_of[rank] = static_cast<std::uint32_t>(row);
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
      if (damping_loss) damping_loss[rank] = damping_loss_[row];
      if (friction_loss) friction_loss[rank] = friction_loss_[row];
      if (death) death[rank] = death_[row];
    }
  });
  contacts = empty_contacts(setup_);
  if (law().remembers()) {
    const auto listed = [&](std::size_t row, std::uint32_t partner) {
      return (partner & wall_flag) != 0 || (partner > rank_[row] && lives(row_of[partner]));
    };
    std::size_t pairs = 0;
    for (std::size_t rank = 0; rank < particles_; ++rank) {
      const std::size_t row = row_of[rank];
      if (!lives(row)) continue;
      for (std::size_t e = remembered_.first[row]; e < remembered_.first[row + 1]; ++e) {
        if (listed(row, remembered_.partner[e])) ++pairs;
      }
    }
    contacts.append(pairs);
    auto* partners = contacts.column<std::uint64_t>(index(ContactField::partner));
    std::size_t pair = 0;
    for (std::size_t rank = 0; rank < particles_; ++rank) {
      const std::size_t row = row_of[rank];
      if (!lives(row)) continue;
      for (std::size_t e = remembered_.first[row]; e < remembered_.first[row + 1]; ++e) {
        const std::uint32_t partner = remembered_.partner[e];
        if (!listed(row, partner)) continue;
        contacts.ids()[pair] = ids_[rank];
        partners[pair] = (partner & wall_flag) != 0 ? soa::obstacle_partner(partner & ~wall_flag)
                                                    : ids_[partner];
        for (std::size_t c = 0; c < 3; ++c) {
          contacts.column<T>(index(ContactField::tangential_displacement), c)[pair] =
              remembered_.tangential[3 * e + c];
          if (law().rolls()) {
            contacts.column<T>(index(ContactField::rolling_displacement), c)[pair] =
                remembered_.rolling[3 * e + c];
          }
        }
        ++pair;
      }
    }
  }
  if (listed_) {
    remembered_ = {};  // the lists have it all
    remembering_ = false;
  }
}

template <class T>
std::size_t Solver<T>::resident_bytes() const {
  std::size_t bytes =
      neighbor_.resident_bytes() + wall_.resident_bytes() + near_.resident_bytes() +
      wall_lists_.resident_bytes() + remembered_.resident_bytes() + rank_.resident_bytes() +
      new_rank_.resident_bytes() + source_.resident_bytes() + place_.resident_bytes() +
      drag_area_.resident_bytes() + death_.resident_bytes() + damping_loss_.resident_bytes() +
      friction_loss_.resident_bytes() + raw_count_.resident_bytes() + raw_first_.resident_bytes();
  for (const auto& places : places_) bytes += places.resident_bytes();
  for (const auto& motions : motions_) bytes += motions.resident_bytes();
  for (const auto& column : search_) bytes += column.resident_bytes();
  for (const auto& lists : long_lists_) bytes += lists.capacity() * sizeof(std::uint32_t);
  return bytes;
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

bool remembers_contacts(const Setup& setup) {
  return setup.contact_law && setup.contact_law->remembers();
}

namespace {

// Measured in piles at rest and in free fall.
constexpr std::uint64_t typical_slots = 9;
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
  row += 7 * sizeof(std::uint32_t);  // places, ranks and counts
  row += 4 * sizeof(double);         // where the broad phase looks
  row += 2 * (sizeof(std::uint64_t) + sizeof(std::uint32_t)) + 2 * sizeof(std::uint32_t);  // cells
  for (const ParticleField field : {ParticleField::drag_area, ParticleField::death,
                                    ParticleField::damping_loss, ParticleField::friction_loss}) {
    if (stored[index(field)]) row += size_of(soa::field(field).scalar, setup.precision);
  }
  const std::uint64_t memory = memory_bytes(setup);
  row += typical_slots * sizeof(std::int32_t);
  // In the lists, and while they are built also apart from them.
  if (memory > 0) row += typical_contacts * (2 * memory + sizeof(std::uint32_t)) + 4;
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
