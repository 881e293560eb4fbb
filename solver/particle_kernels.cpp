// The particle step, compiled once per instruction set: where storage and physics meet. Four packs are advanced in turn so
// that the latency of one pack's square root hides behind the arithmetic of the others, and they stay in registers for all
// steps of the pass.
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

  template <class Integrator>
  Motion<V> free_step(const Motion<V>& motion, const models::ParticleCoefficients<V>& c,
                      const T* instants) const {
    return Integrator::step(motion, dt_, [&](Vec3<V> position, Vec3<V> velocity, Instant instant) {
      return forces_.acceleration(position, velocity, c,
                                  instants + static_cast<std::size_t>(instant) *
                                                 pass_.instant_stride);
    });
  }

  template <class Integrator>
  Motion<V> contact_step(const Motion<V>& motion, const models::ParticleCoefficients<V>& c,
                         const models::ParticleRow<V>& row, const T* instants,
                         typename V::Mask active, models::ContactCount<V>& count) const {
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

  bool any_contact() const { return !pass_.obstacles.empty(); }
  bool bounded() const { return pass_.domain.bounded; }

  typename V::Mask outside(const Vec3<V>& p) const {
    return (p.x < lowest_.x) | (p.y < lowest_.y) | (p.z < lowest_.z) | (p.x > highest_.x) |
           (p.y > highest_.y) | (p.z > highest_.z);
  }

 private:
  const ParticlePass<T>& pass_;
  models::ParticleForces<V> forces_;
  models::Contact<V> contact_;
  V dt_;
  Vec3<V> lowest_;
  Vec3<V> highest_;
};

// `interleaved` packs of neighbouring rows.
template <class V, class Integrator>
class Group {
 public:
  using T = typename V::Real;
  using Mask = typename V::Mask;
  static constexpr std::size_t rows = interleaved * V::width;

  // `remaining`: for each row the steps it still takes, or null when every row takes them all.
  Group(const PassContext<V>& context, const ParticlePass<T>& pass, std::size_t first,
        const T* remaining)
      : context_(context), pass_(pass), first_(first), remaining_(remaining) {
    for_each_pack([&]<std::size_t P>() {
      const std::size_t at = first_ + P * V::width;
      motion_[P] = {{V::load(pass.position[0] + at), V::load(pass.position[1] + at),
                     V::load(pass.position[2] + at)},
                    {V::load(pass.velocity[0] + at), V::load(pass.velocity[1] + at),
                     V::load(pass.velocity[2] + at)}};
      row_[P] = {pass.mass ? V::load(pass.mass + at) : V(pass.uniform_mass),
                 pass.radius ? V::load(pass.radius + at) : V(pass.uniform_radius),
                 pass.drag_area ? V::load(pass.drag_area + at) : V(pass.uniform_drag_area)};
      if (remaining_) {
        // Padding rows are zero; a mass of one keeps their arithmetic finite.
        row_[P].mass = select(row_[P].mass > V(0), row_[P].mass, V(1));
      }
      coefficients_[P] = context.coefficients(row_[P]);
      bad_[P] = Mask(false);
    });
  }

  void advance() {
    const T* instants = pass_.instants;
    if (context_.any_contact() || context_.bounded() || remaining_) {
      for (std::int32_t k = 0; k < pass_.steps; ++k, instants += 2 * pass_.instant_stride) {
        for_each_pack([&]<std::size_t P>() { careful_step<P>(k, instants); });
      }
    } else {
      for (std::int32_t k = 0; k < pass_.steps; ++k, instants += 2 * pass_.instant_stride) {
        for_each_pack([&]<std::size_t P>() {
          motion_[P] =
              context_.template free_step<Integrator>(motion_[P], coefficients_[P], instants);
        });
      }
    }
  }

  bool bad() {
    Mask bad(false);
    for_each_pack([&]<std::size_t P>() {
      bad = bad | bad_[P] | !(is_finite(motion_[P].position) & is_finite(motion_[P].velocity));
    });
    return any(bad);
  }

  void store() const {
    for_each_pack([&]<std::size_t P>() {
      const std::size_t at = first_ + P * V::width;
      motion_[P].position.x.store(pass_.position[0] + at);
      motion_[P].position.y.store(pass_.position[1] + at);
      motion_[P].position.z.store(pass_.position[2] + at);
      motion_[P].velocity.x.store(pass_.velocity[0] + at);
      motion_[P].velocity.y.store(pass_.velocity[1] + at);
      motion_[P].velocity.z.store(pass_.velocity[2] + at);
    });
  }

  ContactTally tally() const {
    ContactTally tally;
    if (!context_.any_contact()) return tally;
    for_each_pack([&]<std::size_t P>() {
      alignas(64) T impacts[V::width];
      alignas(64) T rests[V::width];
      count_[P].impacts.store(impacts);
      count_[P].rests.store(rests);
      for (std::size_t i = 0; i < V::width; ++i) {
        tally.impacts += static_cast<std::uint64_t>(impacts[i]);
        tally.rests += static_cast<std::uint64_t>(rests[i]);
      }
    });
    return tally;
  }

 private:
  template <class Body>
  static void for_each_pack(Body&& body) {
    [&]<std::size_t... P>(std::index_sequence<P...>) {
      (body.template operator()<P>(), ...);
    }(std::make_index_sequence<interleaved>{});
  }

  template <std::size_t P>
  void careful_step(std::int32_t k, const T* instants) {
    const Mask active =
        remaining_ ? V(static_cast<T>(k)) < V::load(remaining_ + P * V::width) : Mask(true);
    const Motion<V> next =
        context_.any_contact()
            ? context_.template contact_step<Integrator>(motion_[P], coefficients_[P], row_[P],
                                                         instants, active, count_[P])
            : context_.template free_step<Integrator>(motion_[P], coefficients_[P], instants);
    motion_[P] = remaining_ ? select(active, next, motion_[P]) : next;
    if (context_.bounded()) bad_[P] = bad_[P] | (active & context_.outside(motion_[P].position));
  }

  const PassContext<V>& context_;
  const ParticlePass<T>& pass_;
  std::size_t first_;
  const T* remaining_;
  Motion<V> motion_[interleaved];
  models::ParticleRow<V> row_[interleaved];
  models::ParticleCoefficients<V> coefficients_[interleaved];
  Mask bad_[interleaved];
  models::ContactCount<V> count_[interleaved];
};

template <class V, class Integrator>
void advance_rows(ParticlePass<typename V::Real>& pass) {
  using T = typename V::Real;
  using Packs = Group<V, Integrator>;
  constexpr std::size_t block = soa::block_rows;
  static_assert(block % Packs::rows == 0);
  const PassContext<V> context(pass);

  for (std::size_t start = pass.first_row; start < pass.last_row; start += block) {
    alignas(64) T remaining[block];
    const bool masked = pass.death || start + block > pass.last_row;
    if (masked) {
      const std::size_t live = std::min(block, pass.last_row - start);
      for (std::size_t i = 0; i < block; ++i) {
        const std::int32_t left = pass.death && i < live ? pass.death[start + i] - pass.first_step
                                                         : pass.steps;
        remaining[i] = static_cast<T>(i < live ? std::clamp(left, 0, pass.steps) : 0);
      }
    }
    std::uint64_t unsaved = 0;
    for (std::size_t g = 0; g < block && start + g < pass.last_row; g += Packs::rows) {
      Packs packs(context, pass, start + g, masked ? remaining + g : nullptr);
      packs.advance();
      if (packs.bad() && !pass.keep_bad) {
        constexpr std::uint64_t ones =
            Packs::rows == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << (Packs::rows % 64)) - 1;
        unsaved |= ones << g;
        continue;
      }
      packs.store();
      const ContactTally tally = packs.tally();
      pass.tally.impacts += tally.impacts;
      pass.tally.rests += tally.rests;
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
    case IntegratorKind::runge_kutta_4: return advance_rows<V, integrators::RungeKutta4>(pass);
    case IntegratorKind::velocity_verlet:
      return advance_rows<V, integrators::VelocityVerlet>(pass);
  }
}

}  // namespace

extern const ParticleKernels particle_kernel_table;
const ParticleKernels particle_kernel_table{&advance<float>, &advance<double>};

}  // namespace SALVO_ISA
}  // namespace salvo::solver
