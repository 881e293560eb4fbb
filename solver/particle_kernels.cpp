// The particle step, compiled once per instruction set: where storage and physics meet.
#include <algorithm>
#include <bit>
#include <type_traits>
#include <utility>

#include "integrators/fixed_step.hpp"
#include "kernels/pair.hpp"
#include "models/contact.hpp"
#include "models/particle.hpp"
#include "soa/column.hpp"
#include "solver/particle_pass.hpp"

namespace salvo::solver {
inline namespace SALVO_ISA {

namespace {

using kernels::Instant;
using kernels::Motion;
using kernels::Pair;
using kernels::Vec3;
using models::ContactResponse;

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
  Motion<V> plain_step(const Motion<V>& motion, const models::ParticleCoefficients<V>& c) const {
    return Integrator::step(motion, dt_, [&](Vec3<V>, Vec3<V> velocity, Instant) {
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

template <class W>
Motion<W> load_motion(const ParticlePass<typename W::Real>& pass, std::size_t at) {
  return {{W::load(pass.position[0] + at), W::load(pass.position[1] + at),
           W::load(pass.position[2] + at)},
          {W::load(pass.velocity[0] + at), W::load(pass.velocity[1] + at),
           W::load(pass.velocity[2] + at)}};
}

template <class W>
void store_motion(const Motion<W>& motion, const ParticlePass<typename W::Real>& pass,
                  std::size_t at) {
  motion.position.x.store(pass.position[0] + at);
  motion.position.y.store(pass.position[1] + at);
  motion.position.z.store(pass.position[2] + at);
  motion.velocity.x.store(pass.velocity[0] + at);
  motion.velocity.y.store(pass.velocity[1] + at);
  motion.velocity.z.store(pass.velocity[2] + at);
}

template <class W>
W load_mass(const ParticlePass<typename W::Real>& pass, std::size_t at) {
  const W mass = pass.mass ? W::load(pass.mass + at) : W(pass.uniform_mass);
  // Padding rows are zero; a mass of one keeps their arithmetic finite.
  return select(mass > W(0), mass, W(1));
}

template <class W>
W load_drag_area(const ParticlePass<typename W::Real>& pass, std::size_t at) {
  return pass.drag_area ? W::load(pass.drag_area + at) : W(pass.uniform_drag_area);
}

template <class V>
void add(const models::ContactCount<V>& count, ContactTally& tally) {
  using T = typename V::Real;
  alignas(soa::alignment) T impacts[V::width];
  alignas(soa::alignment) T rests[V::width];
  count.impacts.store(impacts);
  count.rests.store(rests);
  for (std::size_t i = 0; i < V::width; ++i) {
    tally.impacts += static_cast<std::uint64_t>(impacts[i]);
    tally.rests += static_cast<std::uint64_t>(rests[i]);
  }
}

/// True when a row may not be finite. May cry wolf (a sum of huge finite numbers overflows): the
/// rows are then looked at one by one and come out the same.
template <class W>
bool suspicious(const Motion<W>& motion) {
  const Vec3<W>& x = motion.position;
  const Vec3<W>& v = motion.velocity;
  return any(!is_finite((x.x + x.y) + (x.z + v.x) + (v.y + v.z)));
}

/// The rows [first, first + count) of a block as bits.
constexpr std::uint64_t row_bits(std::size_t first, std::size_t count) {
  return (count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count % 64) - 1) << first;
}

// A pass of one step is bound by memory: ask for the rows of two blocks on while these are
// computed.
template <class T>
void prefetch(const ParticlePass<T>& pass, std::size_t at, std::size_t rows) {
  const std::size_t ahead = at + 2 * soa::block_rows;
  constexpr std::size_t line = soa::alignment / sizeof(T);
  for (std::size_t row = ahead / line * line; row < ahead + rows; row += line) {
    for (std::size_t c = 0; c < 3; ++c) {
      __builtin_prefetch(pass.position[c] + row, 1);
      __builtin_prefetch(pass.velocity[c] + row, 1);
    }
    if (pass.mass) __builtin_prefetch(pass.mass + row, 0);
    if (pass.drag_area) __builtin_prefetch(pass.drag_area + row, 0);
  }
}

// A block whose rows all take every step under plain forces, with nothing in the way: `Count` lanes
// of type W are advanced in turn, and stay in registers for all steps of the pass. One function
// with everything in it, or the compiler keeps the lanes in memory. Returns the rows not saved, as
// bits.
template <class W, std::size_t Count, class Integrator, class Quadratic, class Linear>
[[gnu::noinline]] SALVO_FLATTEN std::uint64_t plain_block(
    const ParticlePass<typename W::Real>& pass, std::size_t start, Quadratic quadratic,
    Linear linear) {
  const models::PlainForces<W> forces(*pass.forces);
  const W dt(pass.dt);
  const W half_density(0.5 * pass.forces->air_density);
  const auto each = [](auto body) __attribute__((always_inline)) {
    [&]<std::size_t... I>(std::index_sequence<I...>) __attribute__((always_inline)) {
      (body.template operator()<I>(), ...);
    }
    (std::make_index_sequence<Count>{});
  };
  std::uint64_t unsaved = 0;
  for (std::size_t g = 0; g < soa::block_rows; g += Count * W::width) {
    Motion<W> motion[Count];
    models::ParticleCoefficients<W> coefficients[Count];
    each([&]<std::size_t I>() __attribute__((always_inline)) {
      const std::size_t at = start + g + I * W::width;
      motion[I] = load_motion<W>(pass, at);
      coefficients[I] = models::plain_coefficients(load_mass<W>(pass, at),
                                                   load_drag_area<W>(pass, at), half_density);
    });
    prefetch(pass, start + g, Count * W::width);
    for (std::int32_t k = 0; k < pass.steps; ++k) {
      each([&]<std::size_t I>() __attribute__((always_inline)) {
        motion[I] = Integrator::step(
            motion[I], dt, [&](Vec3<W>, Vec3<W> velocity, Instant) __attribute__((always_inline)) {
              return forces.acceleration(velocity, coefficients[I], quadratic, linear);
            });
      });
    }
    each([&]<std::size_t I>() __attribute__((always_inline)) {
      const std::size_t at = g + I * W::width;
      if (suspicious(motion[I]) && !pass.keep_bad) {
        unsaved |= row_bits(at, W::width);
      } else {
        store_motion(motion[I], pass, start + at);
      }
    });
  }
  return unsaved;
}

// Which drag there is, as a constant of the loop: a branch a step costs 5 %.
template <class W, std::size_t Count, class Integrator>
std::uint64_t plain_block(const ParticlePass<typename W::Real>& pass, std::size_t start) {
  const bool linear = pass.forces->linear_drag != 0;
  if (!pass.forces->quadratic_drag) {
    return plain_block<W, Count, Integrator>(pass, start, std::false_type{}, linear);
  }
  return linear
             ? plain_block<W, Count, Integrator>(pass, start, std::true_type{}, std::true_type{})
             : plain_block<W, Count, Integrator>(pass, start, std::true_type{}, std::false_type{});
}

// One pack under all forces, with obstacles, a domain, and rows that end within the pass.
// `remaining`: for each row the steps it still takes, or null when every row takes them all. False
// when the rows were not saved.
template <class V, class Integrator>
bool full_pack(const PassContext<V>& context, ParticlePass<typename V::Real>& pass,
               std::size_t first, const typename V::Real* remaining) {
  using T = typename V::Real;
  const models::ParticleRow<V> row{
      load_mass<V>(pass, first),
      pass.radius ? V::load(pass.radius + first) : V(pass.uniform_radius),
      load_drag_area<V>(pass, first)};
  const models::ParticleCoefficients<V> coefficients = context.coefficients(row);
  const V left = remaining ? V::load(remaining) : V(0);
  models::ContactCount<V> count;
  typename V::Mask outside(false);
  Motion<V> motion = load_motion<V>(pass, first);
  const T* instants = pass.instants;
  for (std::int32_t k = 0; k < pass.steps; ++k, instants += 2 * pass.instant_stride) {
    const auto active = remaining ? V(static_cast<T>(k)) < left : typename V::Mask(true);
    const Motion<V> next =
        context.template full_step<Integrator>(motion, coefficients, row, instants, active, count);
    motion = remaining ? select(active, next, motion) : next;
    if (context.bounded()) outside = outside | (active & context.outside(motion.position));
  }
  if ((suspicious(motion) || any(outside)) && !pass.keep_bad) return false;
  store_motion(motion, pass, first);
  if (context.any_contact()) add(count, pass.tally);
  return true;
}

template <class V, class Integrator>
void advance_rows(ParticlePass<typename V::Real>& pass) {
  using T = typename V::Real;
  constexpr std::size_t block = soa::block_rows;
  const PassContext<V> context(pass);

  for (std::size_t start = pass.first_row; start < pass.last_row; start += block) {
    std::uint64_t& unsaved = pass.unsaved[(start - pass.first_row) / block];
    const std::size_t live = std::min(block, pass.last_row - start);
    const bool masked = pass.death || live < block;
    if (context.plain() && !masked) {
      // Two packs side by side, twice: more do not fit the registers, fewer leave the arithmetic
      // waiting for square roots. A single step waits for memory instead.
      unsaved = pass.steps == 1 ? plain_block<V, 1, Integrator>(pass, start)
                                : plain_block<Pair<V>, 2, Integrator>(pass, start);
      pass.steps_taken += static_cast<std::uint64_t>(pass.steps) *
                          (block - static_cast<std::size_t>(std::popcount(unsaved)));
      continue;
    }
    alignas(soa::alignment) T remaining[block];
    for (std::size_t i = 0; i < block; ++i) {
      const std::int32_t left =
          pass.death && i < live ? pass.death[start + i] - pass.first_step : pass.steps;
      remaining[i] = static_cast<T>(i < live ? std::clamp(left, 0, pass.steps) : 0);
    }
    unsaved = 0;
    for (std::size_t g = 0; g < live; g += V::width) {
      if (!full_pack<V, Integrator>(context, pass, start + g, masked ? remaining + g : nullptr)) {
        unsaved |= row_bits(g, V::width);
        continue;
      }
      for (std::size_t i = g; i < g + V::width; ++i) {
        pass.steps_taken += static_cast<std::uint64_t>(remaining[i]);
      }
    }
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
