// The particle step, compiled once per instruction set: where storage and physics meet. Four packs
// are advanced in turn so that the latency of one pack's square root hides behind the arithmetic of
// the others, and they stay in registers for all steps of the pass.
#include <algorithm>
#include <utility>

#include "integrators/fixed_step.hpp"
#include "models/contact.hpp"
#include "models/particle.hpp"
#include "soa/column.hpp"
#include "solver/particle_pass.hpp"

namespace salvo::solver {
inline namespace SALVO_ISA {

namespace {

using kernels::Instant;
using kernels::Motion;
using kernels::Vec3;
using models::ContactResponse;

constexpr std::size_t interleaved = 4;

// Everything that stays the same for all rows of a pass.
template <class V>
class PassContext {
 public:
  using T = typename V::Real;

  explicit PassContext(const ParticlePass<T>& pass)
      : pass_(pass),
        forces_(*pass.forces),
        contact_(pass.obstacles, pass.contact),
        dt_(pass.dt),
        lowest_(models::broadcast<V>(pass.domain.lowest)),
        highest_(models::broadcast<V>(pass.domain.highest)) {}

  models::ParticleCoefficients<V> coefficients(const models::ParticleRow<V>& row) const {
    return forces_.coefficients(row);
  }

  /// One step under gravity, drag and a uniform wind.
  template <class Integrator>
  [[gnu::always_inline]] Motion<V> plain_step(const Motion<V>& motion,
                                              const models::ParticleCoefficients<V>& c) const {
    return Integrator::step(
        motion, dt_, [&](Vec3<V>, Vec3<V> velocity, Instant) __attribute__((always_inline)) {
          return forces_.plain_acceleration(velocity, c);
        });
  }

  /// One step under all forces, and the obstacles.
  template <class Integrator>
  Motion<V> full_step(const Motion<V>& motion, const models::ParticleCoefficients<V>& c,
                      const models::ParticleRow<V>& row, const T* instants, typename V::Mask active,
                      models::ContactCount<V>& count) const {
    if (!any_contact()) return free_step<Integrator>(motion, c, instants);
    switch (pass_.contact.response) {
      case ContactResponse::swept:
        return contact_.resolve(motion, free_step<Integrator>(motion, c, instants), row, dt_,
                                active, count);
      case ContactResponse::impulse:
        return free_step<Integrator>(contact_.respond(motion, row, active, count), c, instants);
      case ContactResponse::force: {
        const auto hit = contact_.book_force(motion, row, dt_, active, count);
        return select(hit.mask, hit.motion, free_step<Integrator>(motion, c, instants));
      }
    }
    return motion;
  }

  /// True when every row takes plain steps.
  bool plain() const { return forces_.plain() && !any_contact() && !bounded(); }
  bool any_contact() const { return !pass_.obstacles.empty(); }
  bool bounded() const { return pass_.domain.bounded; }

  typename V::Mask outside(const Vec3<V>& p) const {
    return (p.x < lowest_.x) | (p.y < lowest_.y) | (p.z < lowest_.z) | (p.x > highest_.x) |
           (p.y > highest_.y) | (p.z > highest_.z);
  }

 private:
  template <class Integrator>
  Motion<V> free_step(const Motion<V>& motion, const models::ParticleCoefficients<V>& c,
                      const T* instants) const {
    if (forces_.plain()) return plain_step<Integrator>(motion, c);
    return Integrator::step(motion, dt_, [&](Vec3<V> position, Vec3<V> velocity, Instant instant) {
      const std::size_t offset = static_cast<std::size_t>(instant) * pass_.instant_stride;
      return forces_.acceleration(position, velocity, c, instants + offset);
    });
  }

  const ParticlePass<T>& pass_;
  models::ParticleForces<V> forces_;
  models::Contact<V> contact_;
  V dt_;
  Vec3<V> lowest_;
  Vec3<V> highest_;
};

// `interleaved` packs of neighbouring rows. Everything is forced inline: the packs must live in
// registers, and a compiler that leaves one call keeps all of them in memory.
template <class V>
class Packs {
 public:
  using T = typename V::Real;
  using Mask = typename V::Mask;
  static constexpr std::size_t rows = interleaved * V::width;

  [[gnu::always_inline]] Packs(const PassContext<V>& context, const ParticlePass<T>& pass,
                               std::size_t first) {
    for_each_pack([&]<std::size_t P>() __attribute__((always_inline)) {
      const std::size_t at = first + P * V::width;
      motion_[P] = {{V::load(pass.position[0] + at), V::load(pass.position[1] + at),
                     V::load(pass.position[2] + at)},
                    {V::load(pass.velocity[0] + at), V::load(pass.velocity[1] + at),
                     V::load(pass.velocity[2] + at)}};
      coefficients_[P] = context.coefficients(row(pass, at));
      prefetch(pass, at);
    });
  }

  /// Every row takes every step, nothing stands in the way.
  template <class Integrator>
  [[gnu::always_inline]] void plain_steps(const PassContext<V>& context, std::int32_t steps) {
    for (std::int32_t k = 0; k < steps; ++k) {
      for_each_pack([&]<std::size_t P>() __attribute__((always_inline)) {
        motion_[P] = context.template plain_step<Integrator>(motion_[P], coefficients_[P]);
      });
    }
  }

  /// All forces, obstacles, the domain and rows that end within the pass. `remaining`: for each row
  /// the steps it still takes, or null when every row takes them all. Marks in `left` the rows that
  /// left the domain on the way.
  template <class Integrator>
  void full_steps(const PassContext<V>& context, const ParticlePass<T>& pass, std::size_t first,
                  const T* remaining, ContactTally& tally) {
    for_each_pack([&]<std::size_t P>() {
      const models::ParticleRow<V> this_row = row(pass, first + P * V::width);
      const V left = remaining ? V::load(remaining + P * V::width) : V(0);
      models::ContactCount<V> count;
      Mask outside(false);
      Motion<V> motion = motion_[P];
      const T* instants = pass.instants;
      for (std::int32_t k = 0; k < pass.steps; ++k, instants += 2 * pass.instant_stride) {
        const Mask active = remaining ? V(static_cast<T>(k)) < left : Mask(true);
        const Motion<V> next = context.template full_step<Integrator>(
            motion, coefficients_[P], this_row, instants, active, count);
        motion = remaining ? select(active, next, motion) : next;
        if (context.bounded()) outside = outside | (active & context.outside(motion.position));
      }
      motion_[P] = motion;
      outside_[P] = outside;
      if (context.any_contact()) add(count, tally);
    });
    left_domain_ = context.bounded();
  }

  /// True when a row is not finite or has left the domain. May cry wolf (a sum of huge finite
  /// numbers overflows): the rows are then looked at one by one and come out the same.
  [[gnu::always_inline]] bool bad() const {
    V sum(0);
    for_each_pack([&]<std::size_t P>() __attribute__((always_inline)) {
      const Vec3<V>& x = motion_[P].position;
      const Vec3<V>& v = motion_[P].velocity;
      sum = sum + ((x.x + x.y) + (x.z + v.x) + (v.y + v.z));
    });
    Mask bad = !is_finite(sum);
    if (left_domain_) {
      for_each_pack([&]<std::size_t P>()
                        __attribute__((always_inline)) { bad = bad | outside_[P]; });
    }
    return any(bad);
  }

  [[gnu::always_inline]] void store(const ParticlePass<T>& pass, std::size_t first) const {
    for_each_pack([&]<std::size_t P>() __attribute__((always_inline)) {
      const std::size_t at = first + P * V::width;
      motion_[P].position.x.store(pass.position[0] + at);
      motion_[P].position.y.store(pass.position[1] + at);
      motion_[P].position.z.store(pass.position[2] + at);
      motion_[P].velocity.x.store(pass.velocity[0] + at);
      motion_[P].velocity.y.store(pass.velocity[1] + at);
      motion_[P].velocity.z.store(pass.velocity[2] + at);
    });
  }

 private:
  template <class Body>
  [[gnu::always_inline]] static void for_each_pack(Body&& body) {
    [&]<std::size_t... P>(std::index_sequence<P...>) __attribute__((always_inline)) {
      (body.template operator()<P>(), ...);
    }
    (std::make_index_sequence<interleaved>{});
  }

  [[gnu::always_inline]] static models::ParticleRow<V> row(const ParticlePass<T>& pass,
                                                           std::size_t at) {
    const V mass = pass.mass ? V::load(pass.mass + at) : V(pass.uniform_mass);
    // Padding rows are zero; a mass of one keeps their arithmetic finite.
    return {select(mass > V(0), mass, V(1)),
            pass.radius ? V::load(pass.radius + at) : V(pass.uniform_radius),
            pass.drag_area ? V::load(pass.drag_area + at) : V(pass.uniform_drag_area)};
  }

  // A pass of one step is bound by memory: ask for the rows of two blocks on while these are
  // computed.
  [[gnu::always_inline]] static void prefetch(const ParticlePass<T>& pass, std::size_t at) {
    const std::size_t ahead = at + 2 * soa::block_rows;
    constexpr std::size_t line = soa::alignment / sizeof(T);
    if (V::width < line && at % line != 0) return;
    for (std::size_t c = 0; c < 3; ++c) {
      __builtin_prefetch(pass.position[c] + ahead, 1);
      __builtin_prefetch(pass.velocity[c] + ahead, 1);
    }
    if (pass.mass) __builtin_prefetch(pass.mass + ahead, 0);
    if (pass.drag_area) __builtin_prefetch(pass.drag_area + ahead, 0);
  }

  static void add(const models::ContactCount<V>& count, ContactTally& tally) {
    alignas(64) T impacts[V::width];
    alignas(64) T rests[V::width];
    count.impacts.store(impacts);
    count.rests.store(rests);
    for (std::size_t i = 0; i < V::width; ++i) {
      tally.impacts += static_cast<std::uint64_t>(impacts[i]);
      tally.rests += static_cast<std::uint64_t>(rests[i]);
    }
  }

  Motion<V> motion_[interleaved];
  models::ParticleCoefficients<V> coefficients_[interleaved];
  Mask outside_[interleaved];
  bool left_domain_ = false;
};

// Rows whose steps are all alike: one call a group, so that the compiler sees the whole loop.
template <class V, class Integrator>
[[gnu::noinline]] bool plain_group(const PassContext<V>& context,
                                   const ParticlePass<typename V::Real>& pass, std::size_t first) {
  Packs<V> packs(context, pass, first);
  packs.template plain_steps<Integrator>(context, pass.steps);
  if (packs.bad() && !pass.keep_bad) return false;
  packs.store(pass, first);
  return true;
}

template <class V, class Integrator>
[[gnu::noinline]] bool full_group(const PassContext<V>& context,
                                  ParticlePass<typename V::Real>& pass, std::size_t first,
                                  const typename V::Real* remaining) {
  Packs<V> packs(context, pass, first);
  ContactTally tally;
  packs.template full_steps<Integrator>(context, pass, first, remaining, tally);
  if (packs.bad() && !pass.keep_bad) return false;
  packs.store(pass, first);
  pass.tally.impacts += tally.impacts;
  pass.tally.rests += tally.rests;
  return true;
}

template <class V, class Integrator>
void advance_rows(ParticlePass<typename V::Real>& pass) {
  using T = typename V::Real;
  constexpr std::size_t block = soa::block_rows;
  constexpr std::size_t group = Packs<V>::rows;
  static_assert(block % group == 0);
  constexpr std::uint64_t group_bits =
      group == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << (group % 64)) - 1;
  const PassContext<V> context(pass);

  for (std::size_t start = pass.first_row; start < pass.last_row; start += block) {
    alignas(64) T remaining[block];
    const bool masked = pass.death || start + block > pass.last_row;
    if (masked) {
      const std::size_t live = std::min(block, pass.last_row - start);
      for (std::size_t i = 0; i < block; ++i) {
        const std::int32_t left =
            pass.death && i < live ? pass.death[start + i] - pass.first_step : pass.steps;
        remaining[i] = static_cast<T>(i < live ? std::clamp(left, 0, pass.steps) : 0);
      }
    }
    std::uint64_t unsaved = 0;
    for (std::size_t g = 0; g < block && start + g < pass.last_row; g += group) {
      const bool saved = context.plain() && !masked
                             ? plain_group<V, Integrator>(context, pass, start + g)
                             : full_group<V, Integrator>(context, pass, start + g,
                                                         masked ? remaining + g : nullptr);
      if (!saved) {
        unsaved |= group_bits << g;
      } else if (masked) {
        for (std::size_t i = g; i < g + group; ++i) {
          pass.steps_taken += static_cast<std::uint64_t>(remaining[i]);
        }
      } else {
        pass.steps_taken += group * static_cast<std::uint64_t>(pass.steps);
      }
    }
    pass.unsaved[(start - pass.first_row) / block] = unsaved;
  }
}

template <class T>
void advance(ParticlePass<T>& pass) {
  using V = kernels::NativeLane<T>;
  switch (pass.integrator) {
    case IntegratorKind::explicit_euler:
      return advance_rows<V, integrators::ExplicitEuler>(pass);
    case IntegratorKind::semi_implicit_euler:
      return advance_rows<V, integrators::SemiImplicitEuler>(pass);
    case IntegratorKind::improved_euler:
      return advance_rows<V, integrators::ImprovedEuler>(pass);
    case IntegratorKind::runge_kutta_4:
      return advance_rows<V, integrators::RungeKutta4>(pass);
    case IntegratorKind::velocity_verlet:
      return advance_rows<V, integrators::VelocityVerlet>(pass);
  }
}

}  // namespace

extern const ParticleKernels particle_kernel_table;
const ParticleKernels particle_kernel_table{&advance<float>, &advance<double>};

}  // namespace SALVO_ISA
}  // namespace salvo::solver
