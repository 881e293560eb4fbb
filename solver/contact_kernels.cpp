// The step of particles that touch, compiled once per instruction set. Lanes are contacts, which
// are picked out of the lists; a particle sums the forces of its own in ascending id, so that no
// sum depends on the order of the rows.
#include <algorithm>
#include <bit>
#include <type_traits>

#include "kernels/impact.hpp"
#include "kernels/quads.hpp"
#include "kernels/sphere_contact.hpp"
#include "models/particle.hpp"
#include "models/sweep.hpp"
#include "models/triangle_mesh.hpp"
#include "soa/column.hpp"
#include "solver/contact_pass.hpp"
#include "solver/list_builder.hpp"

namespace salvo::solver {
inline namespace SALVO_ISA {

namespace {

using kernels::Quad;
using kernels::Vec3;

template <class V>
struct Sphere {
  Vec3<V> position, residual, velocity, spin;
  V radius, mass, path;
};

constexpr std::int32_t consecutive[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

constexpr std::size_t place_numbers = 4;
constexpr std::size_t motion_numbers = 12;

// Quad number `quad` of some rows.
template <class V, std::size_t Numbers, class Row>
[[gnu::always_inline]] inline Quad<V> load(const Row* rows, const std::int32_t* index,
                                           std::size_t quad = 0) {
  static_assert(sizeof(Row) == Numbers * sizeof(typename V::Real));
  return kernels::load_quad<Numbers>(reinterpret_cast<const typename V::Real*>(rows) + 4 * quad,
                                     index, static_cast<const V*>(nullptr));
}
template <std::size_t Numbers, class V, class Row>
[[gnu::always_inline]] inline void store(const Quad<V>& numbers, Row* rows, std::size_t quad = 0) {
  static_assert(sizeof(Row) == Numbers * sizeof(typename V::Real));
  kernels::store_quad<Numbers>(numbers, reinterpret_cast<typename V::Real*>(rows) + 4 * quad);
}

template <class V>
[[gnu::always_inline]] inline void load_place(const SpherePlace<typename V::Real>* rows,
                                              const std::int32_t* index, Sphere<V>& sphere) {
  const Quad<V> place = load<V, place_numbers>(rows, index);
  sphere.position = {place[0], place[1], place[2]};
  sphere.radius = place[3];
}

template <class V>
[[gnu::always_inline]] inline void load_motion(const SphereMotion<typename V::Real>* rows,
                                               const std::int32_t* index, Sphere<V>& sphere) {
  const Quad<V> rest = load<V, motion_numbers>(rows, index);
  const Quad<V> velocity = load<V, motion_numbers>(rows, index, 1);
  const Quad<V> spin = load<V, motion_numbers>(rows, index, 2);
  sphere.residual = {rest[0], rest[1], rest[2]};
  sphere.mass = rest[3];
  sphere.velocity = {velocity[0], velocity[1], velocity[2]};
  sphere.path = velocity[3];
  sphere.spin = {spin[0], spin[1], spin[2]};
}

template <class V, class T>
void store(const Sphere<V>& s, SpherePlace<T>* place, SphereMotion<T>* motion) {
  const auto quad = [](Vec3<V> x, V fourth) { return Quad<V>{x.x, x.y, x.z, fourth}; };
  store<place_numbers>(quad(s.position, s.radius), place);
  store<motion_numbers>(quad(s.residual, s.mass), motion);
  store<motion_numbers>(quad(s.velocity, s.path), motion, 1);
  store<motion_numbers>(quad(s.spin, V(0)), motion, 2);
}

// The memory of one slot of walls for the lanes of a pack.
template <class V>
class SlotMemory {
 public:
  using T = typename V::Real;
  using Mask = typename V::Mask;

  SlotMemory(const WallMemory<T>& memory, std::size_t slot, std::size_t first_lane)
      : bits_(memory.touching + slot),
        first_lane_(first_lane),
        tangential_(place(memory.tangential, slot)),
        rolling_(place(memory.rolling, slot)) {}

  bool touched() const { return (*bits_ >> first_lane_ & lanes) != 0; }
  Vec3<V> tangential() const { return load(tangential_); }
  Vec3<V> rolling() const { return load(rolling_); }
  void set_tangential(Vec3<V> x) { store(x, tangential_); }
  void set_rolling(Vec3<V> x) { store(x, rolling_); }
  void set_touching(std::uint32_t touching) {
    *bits_ =
        static_cast<std::uint16_t>((*bits_ & ~(lanes << first_lane_)) | (touching << first_lane_));
  }

 private:
  static constexpr std::uint32_t lanes = (std::uint32_t{1} << V::width) - 1;

  T* place(T* column, std::size_t slot) const {
    return column ? column + slot * 3 * group_rows + first_lane_ : nullptr;
  }
  static Vec3<V> load(const T* at) {
    return {V::load(at), V::load(at + group_rows), V::load(at + 2 * group_rows)};
  }
  static void store(Vec3<V> x, T* at) {
    x.x.store(at);
    x.y.store(at + group_rows);
    x.z.store(at + 2 * group_rows);
  }

  std::uint16_t* bits_;
  std::size_t first_lane_;
  T* tangential_;
  T* rolling_;
};

// The forces that lose energy and what they lose, four numbers each.
constexpr std::size_t loss_numbers = 8;

// What may touch some rows, to be met a pack at a time: slot after slot, so that the partners of a
// row ascend.
template <class T, std::size_t HistoryColumns, std::size_t Results>
struct ContactBatch {
  static constexpr std::size_t room = 256;
  static constexpr std::size_t rows = room + group_rows;

  std::size_t count = 0;
  alignas(64) std::int32_t own[rows];
  alignas(64) std::int32_t other[rows];
  std::uint64_t slot[rows];
  std::uint32_t touching[rows];  // of the pack that begins at a row, as bits
  alignas(64) T history[HistoryColumns][rows];
  alignas(64) T result[rows * Results];
  alignas(64) T loss[rows * loss_numbers];

  // Packs are whole: what fills up the last one repeats the last contact, and nobody reads what
  // comes of it.
  void fill_up() {
    for (std::size_t n = count; n % group_rows != 0; ++n) {
      own[n] = own[count - 1];
      other[n] = other[count - 1];
      for (auto& column : history) column[n] = column[count - 1];
    }
  }
};

// The memory of a pack of them.
template <class V, class Batch>
class BatchMemory {
 public:
  BatchMemory(Batch& batch, std::size_t first) : batch_(batch), first_(first) {}
  static constexpr bool touched() { return true; }  // a contact that is new holds zeros
  Vec3<V> tangential() const { return load(0); }
  Vec3<V> rolling() const { return load(3); }
  void set_tangential(Vec3<V> x) { store(x, 0); }
  void set_rolling(Vec3<V> x) { store(x, 3); }
  void set_touching(std::uint32_t) {}

 private:
  Vec3<V> load(std::size_t c) const {
    return {V::load(batch_.history[c] + first_), V::load(batch_.history[c + 1] + first_),
            V::load(batch_.history[c + 2] + first_)};
  }
  void store(Vec3<V> x, std::size_t c) {
    x.x.store(batch_.history[c] + first_);
    x.y.store(batch_.history[c + 1] + first_);
    x.z.store(batch_.history[c + 2] + first_);
  }

  Batch& batch_;
  std::size_t first_;
};

// What acts on a sphere. Of that the forces of dashpots and of friction, and the work against them
// with the velocities before the step; only where there is a budget.
template <class V>
struct Sum {
  Vec3<V> force{V(0), V(0), V(0)};
  Vec3<V> torque{V(0), V(0), V(0)};
  Vec3<V> damping{V(0), V(0), V(0)};
  V damping_loss{0};
  Vec3<V> friction{V(0), V(0), V(0)};
  V friction_loss{0};
  Vec3<V> shift{V(0), V(0), V(0)};  // of the position, besides the motion; impulse law
  V approaches{0};
};

// Materials of a kind of partner.
template <class V>
struct Surfaces {
  V damping_ratio;
  V friction;
  V rolling_friction;
  V restitution;
};

// Neighbors are anywhere, which no hardware foresees; but the lists say where.
constexpr std::size_t prefetch_groups = 3;
template <class T, class Pass>
[[gnu::always_inline]] inline void prefetch(const SpherePlace<T>* places, const Pass& pass,
                                            std::size_t group) {
  if (group >= pass.last_group) return;
  const std::int32_t* end = pass.neighbor + pass.first_slot[group + 1] * group_rows;
  for (const std::int32_t* index = pass.neighbor + pass.first_slot[group] * group_rows; index < end;
       ++index) {
    __builtin_prefetch(places + *index);
  }
}

// Whether two touch if what rounding left out of their positions is as unfavorable as can be.
// With u = 2^-24 that is half a unit in the last place of each coordinate, u of it, so that both
// together and the rounding of the test itself come to (1 + 5.5 u) reach + 2 u (|x| + |y| + |z|).
// Of the 8 u here some pays for the rounding of the sum: 4 u would not do.
template <class V>
constexpr double rounding = sizeof(typename V::Real) == 4 ? 0x1p-21 : 0;

// A radius that is no radius is so negative that its square's sign decides.
template <class V>
typename V::Mask reaches(Vec3<V> offset, V reach) {
  return norm_squared(offset) < reach * abs(reach);
}

// Who of some slots of a group may be within a margin of touching, by their places alone, as bits.
template <class V>
[[gnu::always_inline]] inline void find_near(const SpherePlace<typename V::Real>* places,
                                             std::size_t group, V margin,
                                             const std::int32_t* neighbor, std::size_t slots,
                                             std::uint16_t* near) {
  for (std::size_t lane = 0; lane < group_rows; lane += V::width) {
    Sphere<V> own;
    load_place(places + group * group_rows + lane, consecutive, own);
    own.radius = own.radius + margin;
    const V slack =
        (abs(own.position.x) + abs(own.position.y) + abs(own.position.z)) * V(rounding<V>);
    for (std::size_t n = 0; n < slots; ++n) {
      Sphere<V> other;
      load_place(places, neighbor + n * group_rows + lane, other);
      V reach = own.radius + other.radius;
      if constexpr (rounding < V >> 0) reach = reach * V(1 + rounding<V>) + slack;
      const std::uint32_t now = bits(reaches(own.position - other.position, reach));
      near[n] = static_cast<std::uint16_t>((lane == 0 ? 0U : near[n]) | now << lane);
    }
  }
}

// `Counting`: no step, but how many contacts of each row approach.
template <class Law, bool Friction, bool Rolling, bool Counting = false>
class Step {
 public:
  using V = typename Law::Lanes;
  using T = typename V::Real;
  using Mask = typename V::Mask;

  explicit Step(ContactPass<T>& pass)
      : pass_(pass),
        law_(*pass.law),
        between_{V(pass.damping_ratio), V(pass.law->friction), V(pass.law->rolling_friction),
                 V(pass.law->restitution)},
        equal_pair_(pass.equal ? equal_pair(pass) : kernels::ContactPair<V>{}),
        push_out_(pass.law->push_out),
        pull_(4 * kernels::pi * pass.law->surface_energy),
        cohesive_(pass.law->surface_energy != 0),
        budget_(pass.damping_loss != nullptr),
        forces_(*pass.forces),
        dt_(pass.dt),
        lowest_(models::broadcast<V>(pass.domain.lowest)),
        highest_(models::broadcast<V>(pass.domain.highest)) {}

  void advance() {
    for (std::size_t first = pass_.first_group; first < pass_.last_group; first += chunk_groups) {
      advance_chunk(first, std::min(first + chunk_groups, pass_.last_group));
    }
  }

 private:
  using SphereV = Sphere<V>;
  static constexpr bool remembers = Friction && !Law::impulsive;
  static constexpr std::size_t history_columns = !remembers ? 0 : Rolling ? 6 : 3;
  // Four numbers each: the force, the torque, the shift.
  static constexpr std::size_t results = Counting ? 4 : Law::impulsive ? 12 : Friction ? 8 : 4;
  static constexpr std::size_t chunk_groups = 32;
  using Batch = ContactBatch<T, history_columns == 0 ? 1 : history_columns, results>;

  void advance_chunk(std::size_t first, std::size_t last) {
    first_row_ = first * group_rows;
    std::fill_n(sums_, (last - first) * group_rows * results, T(0));
    if (budget_) std::fill_n(losses_, (last - first) * group_rows * loss_numbers, T(0));
    for (std::size_t group = first; group < last; ++group) {
      prefetch(pass_.from.place, pass_, group + prefetch_groups);
      find_contacts(group);
    }
    meet_batch();
    for (std::size_t row = first_row_; row < last * group_rows; row += V::width) advance_pack(row);
  }

  void advance_pack(std::size_t row) {
    SphereV own;
    load_place(pass_.from.place + row, consecutive, own);
    load_motion(pass_.from.motion + row, consecutive, own);
    Sum<V> sum = sum_of(row);
    if constexpr (Law::impulsive && !Counting) own_approaches_ = V::load(pass_.approaches + row);
    if (!Counting && budget_) keep_impulse(sum.force * dt_, row);
    if (!pass_.walls.empty()) meet_walls(own, row / group_rows, row % group_rows, sum);
    if constexpr (Counting) {
      sum.approaches.store(pass_.approaches + row);
    } else {
      move(own, row, sum);
    }
  }

  void keep_impulse(Vec3<V> impulse, std::size_t row) {
    T* const* sums = pass_.contact_impulse;
    (V::load(sums[0] + row) + impulse.x).store(sums[0] + row);
    (V::load(sums[1] + row) + impulse.y).store(sums[1] + row);
    (V::load(sums[2] + row) + impulse.z).store(sums[2] + row);
  }

  // First who may touch, by their places alone and for many slots in one go without a branch; then
  // those are picked out: most of what is near does not touch, and a pack is to be full of what
  // does.
  SALVO_FLATTEN void find_contacts(std::size_t group) {
    constexpr std::size_t most = 64;
    const std::size_t last = pass_.first_slot[group + 1];
    for (std::size_t start = pass_.first_slot[group]; start < last; start += most) {
      const std::size_t count = std::min(most, last - start);
      std::uint16_t near[most];
      find_near(pass_.from.place, group, V(0), pass_.neighbor + start * group_rows, count, near);
      for (std::size_t n = 0; n < count; ++n) pick_contacts(group, start + n, near[n]);
    }
  }

  void pick_contacts(std::size_t group, std::size_t slot, std::uint32_t near) {
    std::uint32_t touched = 0;
    if constexpr (remembers) {
      touched = pass_.history.touching[slot];
      pass_.history.touching[slot] = 0;
    }
    std::size_t count = batch_.count;
    for (std::uint32_t left = near | touched; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      const std::int32_t other = pass_.neighbor[slot * group_rows + lane];
      batch_.own[count] = static_cast<std::int32_t>(group * group_rows + lane);
      batch_.other[count] = other;
      __builtin_prefetch(pass_.from.motion[other].residual);
      __builtin_prefetch(pass_.from.motion[other].spin);
      if constexpr (remembers) {
        batch_.slot[count] = slot;
        const std::uint32_t held = touched >> lane & 1;
        for (std::size_t c = 0; c < history_columns; ++c) {
          const T* kept = pass_.history.before + c * pass_.history.count_before + remembered_;
          batch_.history[c][count] = held != 0 ? *kept : T(0);
        }
        remembered_ += held;
      }
      count += near >> lane & 1;
    }
    batch_.count = count;
    if (count > Batch::room - group_rows) meet_batch();
  }

  // What the contacts found so far do to the rows.
  SALVO_FLATTEN void meet_batch() {
    if (batch_.count == 0) return;
    batch_.fill_up();
    for (std::size_t n = 0; n < batch_.count; n += V::width) meet_contacts(n);
    add_up<results>(batch_.result, sums_);
    if (budget_) add_up<loss_numbers>(batch_.loss, losses_);
    if constexpr (remembers) keep_history();
    batch_.count = 0;
  }

  template <std::size_t Numbers>
  void add_up(const T* results_of_contacts, T* sums) const {
    for (std::size_t n = 0; n < batch_.count; ++n) {
      T* sum = sums + (static_cast<std::size_t>(batch_.own[n]) - first_row_) * Numbers;
      const T* result = results_of_contacts + n * Numbers;
      T total[Numbers];  // so that the compiler sees that nothing overlaps
      for (std::size_t k = 0; k < Numbers; ++k) total[k] = sum[k] + result[k];
      for (std::size_t k = 0; k < Numbers; ++k) sum[k] = total[k];
    }
  }

  void keep_history() {
    ContactHistory<T>& history = pass_.history;
    for (std::size_t n = 0; n < batch_.count; ++n) {
      const std::uint32_t touching = batch_.touching[n / V::width * V::width] >> n % V::width & 1;
      const std::size_t lane = static_cast<std::size_t>(batch_.own[n]) % group_rows;
      std::uint16_t& bits = history.touching[batch_.slot[n]];
      bits = static_cast<std::uint16_t>(bits | touching << lane);
      for (std::size_t c = 0; c < history_columns; ++c) {
        history.after[c * history.room + history.count] = batch_.history[c][n];
      }
      history.count += touching;
    }
  }

  void keep(const Sum<V>& sum, std::size_t n) {
    T* to = batch_.result + n * results;
    const V none(0);
    if constexpr (Counting) {
      put<results>({none, none, none}, sum.approaches, to);
    } else {
      put<results>(sum.force, none, to);
      if constexpr (results > 4) put<results>(sum.torque, none, to + 4);
      if constexpr (results > 8) put<results>(sum.shift, none, to + 8);
      if (!budget_) return;
      T* loss = batch_.loss + n * loss_numbers;
      put<loss_numbers>(sum.damping, sum.damping_loss, loss);
      put<loss_numbers>(sum.friction, sum.friction_loss, loss + 4);
    }
  }
  Sum<V> sum_of(std::size_t row) const {
    const T* from = sums_ + (row - first_row_) * results;
    Sum<V> sum;
    V none(0);
    if constexpr (Counting) {
      take<results>(from, sum.force, sum.approaches);
    } else {
      take<results>(from, sum.force, none);
      if constexpr (results > 4) take<results>(from + 4, sum.torque, none);
      if constexpr (results > 8) take<results>(from + 8, sum.shift, none);
      if (!budget_) return sum;
      const T* loss = losses_ + (row - first_row_) * loss_numbers;
      take<loss_numbers>(loss, sum.damping, sum.damping_loss);
      take<loss_numbers>(loss + 4, sum.friction, sum.friction_loss);
    }
    return sum;
  }
  template <std::size_t Numbers>
  static void put(Vec3<V> x, V fourth, T* to) {
    kernels::store_quad<Numbers>(Quad<V>{x.x, x.y, x.z, fourth}, to);
  }
  template <std::size_t Numbers>
  static void take(const T* from, Vec3<V>& x, V& fourth) {
    const auto q = kernels::load_quad<Numbers>(from, consecutive, static_cast<const V*>(nullptr));
    x = {q[0], q[1], q[2]};
    fourth = q[3];
  }

  // A pack of contacts.
  void meet_contacts(std::size_t first) {
    SphereV own;
    SphereV other;
    load_place(pass_.from.place, batch_.own + first, own);
    load_motion(pass_.from.motion, batch_.own + first, own);
    load_place(pass_.from.place, batch_.other + first, other);
    load_motion(pass_.from.motion, batch_.other + first, other);
    const Vec3<V> offset = (own.position - other.position) + (own.residual - other.residual);
    const V reach = own.radius + other.radius;
    const Mask touching = reaches(offset, reach);
    batch_.touching[first] = bits(touching);
    const V distance = norm(offset);
    kernels::SphereContact<V> contact;
    // Two centers at the same place have no direction, and no force until they part.
    contact.normal = offset * (V(1) / select(distance > V(0), distance, V(1)));
    contact.overlap = max(reach - distance, V(0));
    const V half = V(0.5) * contact.overlap;
    const Vec3<V> turning = own.spin * (own.radius - half) + other.spin * (other.radius - half);
    contact.lever = own.radius - half;
    contact.velocity = (own.velocity - other.velocity) - cross(turning, contact.normal);
    kernels::ContactPair<V> pair = equal_pair_;
    if (!pass_.equal) {
      pair.mass = own.mass * other.mass / (own.mass + other.mass);
      pair.radius = own.radius * other.radius / (own.radius + other.radius);
      pair.damping = law_.damping(pair.mass, between_.damping_ratio);
    }
    if (Rolling) contact.rolling = cross(own.spin - other.spin, contact.normal) * pair.radius;
    BatchMemory<V, Batch> memory(batch_, first);
    Sum<V> sum;
    if constexpr (Law::impulsive) {
      V others(1);
      if constexpr (!Counting) {
        own_approaches_ = V::gather(pass_.approaches, batch_.own + first);
        others = V::gather(pass_.approaches, batch_.other + first);
      }
      strike(contact, pair, between_, touching, memory, others, own.mass, V(0.5), sum);
    } else {
      add(contact, pair, between_, touching, memory, V(0.5), sum);
    }
    keep(sum, first);
  }

  void meet_walls(const SphereV& own, std::size_t group, std::size_t lane, Sum<V>& sum) {
    const std::uint64_t* first = pass_.first_wall_slot + group;
    WallView view;
    for (std::size_t slot = first[0]; slot < first[1]; ++slot) {
      const WallPart part = pass_.wall_parts[pass_.wall_part[slot]];
      if (view.wall != part.wall) view = seen_from(part.wall, own);
      meet_wall(own, view, part.feature, slot, lane, sum);
    }
  }

  // The particles as seen from the center of a wall, along the axes of the scene and of a mesh.
  struct WallView {
    std::uint32_t wall = ~std::uint32_t{0};
    Vec3<V> p;
    Vec3<V> own_axes;
  };
  static kernels::Quat<V> turn_of(const models::Obstacle& shape) {
    const std::array<double, 4>& q = shape.rotation;
    return {V(q[0]), V(q[1]), V(q[2]), V(q[3])};
  }
  [[gnu::noinline]] WallView seen_from(std::uint32_t number, const SphereV& own) const {
    const Wall& wall = pass_.walls[number];
    // In float with what rounding the center leaves out.
    const Vec3<V> rest =
        sizeof(T) == 4 ? models::broadcast<V>(wall.center_rest) : Vec3<V>{V(0), V(0), V(0)};
    const Vec3<V> p =
        (own.position - models::broadcast<V>(wall.shape.center)) + (own.residual - rest);
    const bool is_mesh = wall.shape.shape == models::ObstacleShape::mesh;
    return {number, p, is_mesh ? rotate(conjugate(turn_of(wall.shape)), p) : p};
  }

  struct WallSurface {
    V distance;  // of the center from the surface, m
    Vec3<V> normal;
    Mask owns;
  };

  static WallSurface wall_surface(const models::Obstacle& shape, std::size_t feature,
                                  const WallView& view, V radius) {
    const Mask always(true);
    if (shape.shape == models::ObstacleShape::mesh) {
      const auto own = feature_surface(*shape.mesh, feature, view.own_axes);
      return {own.distance, rotate(turn_of(shape), own.normal), own.owns};
    }
    if (shape.shape == models::ObstacleShape::height_field) {
      // It measures from the surface of the sphere.
      const kernels::Surface<V> field = models::field_surface(*shape.samples, view.p, radius);
      return {field.distance + radius, field.normal, always};
    }
    const kernels::Surface<V> solid = models::solid_surface(shape, view.p);
    if (shape.hollow) return {-solid.distance, -solid.normal, always};
    return {solid.distance, solid.normal, always};
  }

  // Which particles may reach a feature of a mesh: most of those that are near some particle of a
  // group are far from the others. A hundredth of the radius covers rounding.
  static Mask may_reach(const models::MeshBounds& bounds, Vec3<V> p, V radius) {
    const V reach = V(1.01) * radius;
    const auto outside = [&](V at, std::size_t axis) {
      return (at + reach < V(bounds.lowest[axis])) | (at - reach > V(bounds.highest[axis]));
    };
    return !(outside(p.x, 0) | outside(p.y, 1) | outside(p.z, 2));
  }

  [[gnu::noinline]] void meet_wall(const SphereV& own, const WallView& view, std::size_t feature,
                                   std::size_t slot, std::size_t lane, Sum<V>& sum) {
    const Wall& wall = pass_.walls[view.wall];
    const Vec3<V>& p = view.p;
    SlotMemory<V> memory(pass_.wall_memory, slot, lane);
    Mask near(true);
    if (wall.shape.shape == models::ObstacleShape::mesh) {
      near = may_reach(wall.shape.mesh->bounds[feature], view.own_axes, own.radius);
      if (!any(near)) {
        if (memory.touched()) forget(memory);
        return;
      }
    }
    const WallSurface surface = wall_surface(wall.shape, feature, view, own.radius);
    const V distance = surface.distance;
    const Mask touching = near & surface.owns & (distance < own.radius) & (own.radius > V(0));
    if (!any(touching)) {
      if (memory.touched()) forget(memory);
      return;
    }
    kernels::SphereContact<V> contact;
    contact.normal = surface.normal;
    contact.overlap = max(own.radius - distance, V(0));
    contact.lever = distance;
    const Vec3<V> wall_velocity =
        models::broadcast<V>(wall.velocity) +
        cross(models::broadcast<V>(wall.angular_velocity), p - contact.normal * distance);
    contact.velocity =
        (own.velocity - wall_velocity) - cross(own.spin * contact.lever, contact.normal);
    if (Rolling) {
      const Vec3<V> turning = own.spin - models::broadcast<V>(wall.angular_velocity);
      contact.rolling = cross(turning, contact.normal) * own.radius;
    }
    const Surfaces<V> surfaces{V(wall.damping_ratio), V(wall.shape.friction),
                               between_.rolling_friction, V(wall.shape.restitution)};
    const kernels::ContactPair<V> pair{own.mass, own.radius,
                                       law_.damping(own.mass, surfaces.damping_ratio)};
    if constexpr (Law::impulsive) {
      strike(contact, pair, surfaces, touching, memory, V(1), own.mass, V(1), sum);
    } else {
      add(contact, pair, surfaces, touching, memory, V(1), sum);
    }
  }

  // `share`: the part of the losses that this sphere stands for.
  template <class Memory>
  void add(const kernels::SphereContact<V>& contact, const kernels::ContactPair<V>& pair,
           const Surfaces<V>& surfaces, Mask touching, Memory& memory, V share, Sum<V>& sum) {
    using Spring = kernels::SlipSpring<V>;
    const Vec3<V> nothing{V(0), V(0), V(0)};
    const auto springs = law_.at(contact.overlap, pair);
    const V apart = dot(contact.velocity, contact.normal);
    const V pull = cohesive_ ? pull_ * pair.radius : V(0);
    const auto normal = kernels::normal_force(springs, apart, pull);
    Vec3<V> force = contact.normal * normal.along;
    Vec3<V> torque = nothing;
    Vec3<V> friction = nothing;
    V friction_loss(0);
    if (Friction) {
      const Vec3<V> slip = contact.velocity - contact.normal * apart;
      const bool touched = memory.touched();
      const Spring sliding(touched ? memory.tangential() : nothing, contact.normal, slip, springs,
                           surfaces.friction * normal.pressing, dt_);
      memory.set_tangential(select(touching, sliding.after, nothing));
      friction = -sliding.force;
      force += friction;
      torque = cross(contact.normal, sliding.force) * contact.lever;
      if (budget_) friction_loss = sliding.work(slip, dt_);
      if (Rolling) {
        const Spring rolling(touched ? memory.rolling() : nothing, contact.normal, contact.rolling,
                             springs, surfaces.rolling_friction * normal.pressing, dt_);
        memory.set_rolling(select(touching, rolling.after, nothing));
        torque -= cross(contact.normal, rolling.force) * pair.radius;
        if (budget_) friction_loss = friction_loss + rolling.work(contact.rolling, dt_);
      }
    }
    memory.set_touching(bits(touching));
    sum.force += select(touching, force, nothing);
    if (Friction) sum.torque += select(touching, torque, nothing);
    if (budget_) {
      const V damping = normal.pressing - springs.elastic;
      lose(touching, contact.normal * damping, -(damping * apart * dt_) * share, friction,
           friction_loss * share, sum);
    }
  }

  static void lose(Mask where, Vec3<V> damping, V damping_loss, Vec3<V> friction, V friction_loss,
                   Sum<V>& sum) {
    const Vec3<V> nothing{V(0), V(0), V(0)};
    sum.damping += select(where, damping, nothing);
    sum.damping_loss = sum.damping_loss + select(where, damping_loss, V(0));
    sum.friction += select(where, friction, nothing);
    sum.friction_loss = sum.friction_loss + select(where, friction_loss, V(0));
  }

  // The impulse law. Each impulse alone takes kinetic energy, and of those of a row and of its
  // partner each counts as one of the larger number: what a row gets is a weighted mean of its
  // impulses, and as kinetic energy is convex, all together never add any. Momentum stays, because
  // both partners take the same weight.
  template <class Memory>
  void strike(const kernels::SphereContact<V>& contact, const kernels::ContactPair<V>& pair,
              const Surfaces<V>& surfaces, Mask touching, Memory& memory, V others, V mass, V share,
              Sum<V>& sum) {
    const V apart = dot(contact.velocity, contact.normal);
    const Mask strikes = touching & (apart < V(0));
    if constexpr (Counting) {
      sum.approaches = sum.approaches + select(strikes, V(1), V(0));
    } else {
      const Vec3<V> nothing{V(0), V(0), V(0)};
      const Vec3<V> slip = contact.velocity - contact.normal * apart;
      const V weight = V(1) / max(max(own_approaches_, others), V(1));
      const Vec3<V> impulse = kernels::approach_impulse(contact.normal, slip, apart, pair.mass,
                                                        surfaces.restitution, surfaces.friction) *
                              weight;
      sum.force += select(strikes, impulse * (V(1) / dt_), nothing);
      if (Friction) {
        const Vec3<V> torque = cross(contact.normal, impulse) * (-contact.lever / dt_);
        sum.torque += select(strikes, torque, nothing);
      }
      // Overlaps are taken back little by little, the lighter of the two moving more.
      const V back = push_out_ * contact.overlap * weight * (pair.mass / mass);
      sum.shift += select(touching, contact.normal * back, nothing);
      memory.set_touching(bits(touching));
      if (budget_) {
        const V along = dot(impulse, contact.normal);
        const Vec3<V> across = impulse - contact.normal * along;
        lose(strikes, contact.normal * (along / dt_), -(along * apart) * share,
             across * (V(1) / dt_), -dot(across, slip) * share, sum);
      }
    }
  }

  // The same operations as for any two, on particles that are all alike.
  kernels::ContactPair<V> equal_pair(const ContactPass<T>& pass) const {
    const V mass(pass.uniform_mass);
    const V radius(pass.uniform_radius);
    const V effective = mass * mass / (mass + mass);
    return {effective, radius * radius / (radius + radius),
            law_.damping(effective, between_.damping_ratio)};
  }

  void forget(SlotMemory<V>& memory) {
    const Vec3<V> nothing{V(0), V(0), V(0)};
    if (Friction && !Law::impulsive) memory.set_tangential(nothing);
    if (Rolling) memory.set_rolling(nothing);
    memory.set_touching(0);
  }

  // Semi-implicit Euler, which on positions is the leapfrog of velocity Verlet. Positions keep what
  // rounding leaves out: v dt may be far below what a float position resolves.
  SALVO_FLATTEN void move(SphereV& own, std::size_t row, const Sum<V>& sum) {
    const Mask alive = own.radius > V(0);
    const V drag_area =
        pass_.drag_area ? V::load(pass_.drag_area + row) : V(pass_.uniform_drag_area);
    const V mass = select(alive, own.mass, V(1));
    const auto c = forces_.coefficients({mass, own.radius, drag_area});
    const Vec3<V> field = forces_.plain()
                              ? forces_.plain_acceleration(own.velocity, c)
                              : forces_.acceleration(own.position, own.velocity, c, pass_.instants);
    SphereV next = own;
    next.velocity = own.velocity + (field + sum.force * c.inverse_mass) * dt_;
    Vec3<V> way = next.velocity * dt_;
    if constexpr (Law::impulsive) way += sum.shift;
    if constexpr (sizeof(T) == 4) {
      const Vec3<V> gain = own.residual + way;
      way = gain - own.residual;
      next.position = own.position + gain;
      next.residual = {kernels::sum_error(own.position.x, gain.x, next.position.x),
                       kernels::sum_error(own.position.y, gain.y, next.position.y),
                       kernels::sum_error(own.position.z, gain.z, next.position.z)};
    } else {
      next.position = own.position + way;
      way = next.position - own.position;
    }
    // Far from the origin the way that is gone is not quite the one that was to be.
    next.path = own.path + norm(way);
    if (Friction) {
      const V inertia = V(0.4) * mass * own.radius * own.radius;
      next.spin = own.spin + sum.torque * (dt_ / select(alive, inertia, V(1)));
    }
    if (pass_.death) {
      alignas(soa::alignment) T dies[V::width];
      for (std::size_t i = 0; i < V::width; ++i) {
        dies[i] = pass_.death[row + i] <= pass_.step + 1 ? T(1) : T(0);
      }
      next.radius = select(V::load(dies) > V(0), V(no_radius), next.radius);
    }
    if (budget_) {
      // The work against a force is that at the mean of the velocities before and after the step:
      // just what kinetic energy it takes, whatever else acts. Half their change is missing yet.
      const V half = V(0.5) * dt_;
      const Vec3<V> gain = next.velocity - own.velocity;
      const auto add_loss = [&](T* column, V loss, V late) {
        (V::load(column + row) + select(alive, loss - late * half, V(0))).store(column + row);
      };
      add_loss(pass_.damping_loss, sum.damping_loss, dot(sum.damping, gain));
      add_loss(pass_.friction_loss, sum.friction_loss,
               dot(sum.friction, gain) + dot(sum.torque, next.spin - own.spin));
    }
    watch(next, alive);
    next.position = select(alive, next.position, own.position);
    next.residual = select(alive, next.residual, own.residual);
    next.velocity = select(alive, next.velocity, own.velocity);
    next.spin = select(alive, next.spin, own.spin);
    next.path = select(alive, next.path, own.path);
    store(next, pass_.to.place + row, pass_.to.motion + row);
  }

  void watch(const SphereV& next, Mask alive) {
    const Vec3<V>& x = next.position;
    const Vec3<V>& v = next.velocity;
    const Vec3<V>& w = next.spin;
    Mask bad = !is_finite((x.x + x.y) + (x.z + v.x) + (v.y + v.z) + (w.x + w.y) + w.z);
    if (pass_.domain.bounded) {
      bad = bad | (x.x < lowest_.x) | (x.y < lowest_.y) | (x.z < lowest_.z) | (x.x > highest_.x) |
            (x.y > highest_.y) | (x.z > highest_.z);
    }
    pass_.bad = pass_.bad || any(bad & alive);
    longest_ = max(longest_, select(alive, next.path, V(0)));
    pass_.steps_taken += static_cast<std::uint64_t>(std::popcount(bits(alive)));
    if (any(longest_ > V(pass_.longest_path))) {
      alignas(soa::alignment) T paths[V::width];
      longest_.store(paths);
      for (const T path : paths) {
        pass_.longest_path = std::max(pass_.longest_path, static_cast<double>(path));
      }
    }
  }

  ContactPass<T>& pass_;
  const Law law_;
  const Surfaces<V> between_;
  const kernels::ContactPair<V> equal_pair_;
  V own_approaches_{0};
  const V push_out_;
  const V pull_;
  const bool cohesive_;
  const bool budget_;
  const models::ParticleForces<V> forces_;
  const V dt_;
  const Vec3<V> lowest_;
  const Vec3<V> highest_;
  V longest_{0};

  Batch batch_;
  std::size_t remembered_ = 0;  // contacts of the last step that were passed
  std::size_t first_row_ = 0;   // of the chunk
  alignas(64) T sums_[chunk_groups * group_rows * results];
  alignas(64) T losses_[chunk_groups * group_rows * loss_numbers];
};

template <class V>
struct Linear : kernels::LinearSpring<V> {
  using Lanes = V;
  static constexpr bool impulsive = false;
  explicit Linear(const models::ContactLaw& law)
      : kernels::LinearSpring<V>{
            V(law.normal_stiffness), V(law.normal_stiffness * law.tangential_ratio),
            V(1 / (law.normal_stiffness * law.tangential_ratio)), V(law.tangential_damping)} {}
};

template <class V>
struct Hertz : kernels::HertzMindlin<V> {
  using Lanes = V;
  static constexpr bool impulsive = false;
  explicit Hertz(const models::ContactLaw& law)
      : kernels::HertzMindlin<V>{V(models::effective_young(law)), V(models::effective_shear(law)),
                                 V(law.tangential_damping)} {}
};

template <class V>
struct Impulse {
  using Lanes = V;
  static constexpr bool impulsive = true;
  explicit Impulse(const models::ContactLaw&) {}
  V damping(V /*mass*/, V /*zeta*/) const { return V(0); }
};

template <class Law>
void advance_law(ContactPass<typename Law::Lanes::Real>& pass) {
  if (pass.law->rolls()) {
    Step<Law, true, true>(pass).advance();
  } else if (pass.law->turns()) {
    Step<Law, true, false>(pass).advance();
  } else {
    Step<Law, false, false>(pass).advance();
  }
}

template <class T>
void advance(ContactPass<T>& pass) {
  using V = kernels::NativeLane<T>;
  switch (pass.law->kind) {
    case models::ContactLawKind::linear_spring:
      return advance_law<Linear<V>>(pass);
    case models::ContactLawKind::hertz_mindlin:
      return advance_law<Hertz<V>>(pass);
    case models::ContactLawKind::impulse:
      return pass.law->turns() ? Step<Impulse<V>, true, false>(pass).advance()
                               : Step<Impulse<V>, false, false>(pass).advance();
  }
}

template <class T>
void count(ContactPass<T>& pass) {
  using V = kernels::NativeLane<T>;
  pass.law->turns() ? Step<Impulse<V>, true, false, true>(pass).advance()
                    : Step<Impulse<V>, false, false, true>(pass).advance();
}

template <class T>
void prune(PrunePass<T>& pass) {
  using V = kernels::NativeLane<T>;
  for (std::size_t group = pass.first_group; group < pass.last_group; ++group) {
    prefetch(pass.place, pass, group + prefetch_groups);
    const std::size_t first = pass.first_slot[group];
    find_near(pass.place, group, V(pass.margin), pass.neighbor + first * group_rows,
              pass.first_slot[group + 1] - first, pass.near + first);
  }
}

void list_neighbors(ListPass& pass) { ListBuilder(pass).build(); }

}  // namespace

extern const ContactKernels contact_kernel_table;
const ContactKernels contact_kernel_table{&list_neighbors, &prune<float>,    &prune<double>,
                                          &advance<float>, &advance<double>, &count<float>,
                                          &count<double>};

}  // namespace SALVO_ISA
}  // namespace salvo::solver
