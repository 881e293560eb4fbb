// Emitters: where particles come from. Every draw is keyed by (seed, stream, serial), so a burst
// gives the bits it would give alone.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "models/force_settings.hpp"
#include "soa/table.hpp"

namespace salvo::solver {

class Parallel;
using models::Triple;

/// A number that may differ from particle to particle: `a` alone, uniform on [a, b), or normal with
/// mean a and standard deviation b, truncated to within four standard deviations and to positive
/// values.
struct Spread {
  enum class Kind { constant, uniform, normal } kind = Kind::constant;
  double a = 0;
  double b = 0;

  bool varies() const { return kind != Kind::constant; }
  /// What draws stay above and below; of a normal one that comes near zero the least is negative.
  double least() const { return kind == Kind::normal ? a - 4 * b : a; }
  double greatest() const {
    return kind == Kind::normal ? a + 4 * b : kind == Kind::uniform ? b : a;
  }
};

enum class EmitterKind {
  burst,             ///< from a point or ball, in all directions
  shell,             ///< from the surface of a sphere, outward
  cone,              ///< into a cone about a direction
  jet,               ///< into a cone about a direction, at a rate, for a duration
  book_explosion,    ///< Bourg & Bywalec 2.6: plane, whole-number speeds, angles and lives
  energy_explosion,  ///< Bourg & Bywalec 18.4.1: speeds from an energy budget
  lattice,           ///< at the sites of a lattice, without overlap
};

/// Where a lattice has its sites: `cubic` at the corners of cubes, `close_packed` in hexagonal
/// layers as densely as equal spheres go. Layers follow one another along y.
enum class LatticeKind { cubic, close_packed };

/// What a lattice fills of its box: all, the largest ellipsoid, or the largest cone that points up.
enum class LatticeShape { box, ellipsoid, cone };

/// How an energy explosion shares its budget. `book` draws each speed from what is left, in order;
/// the others scale drawn shares so that the budget is met from below.
enum class EnergyShares { equal, uniform, normal, book };

struct Emitter {
  EmitterKind kind = EmitterKind::burst;
  std::string name;
  std::uint64_t stream = 0;
  std::uint64_t count = 0;    ///< particles; for a jet it follows from rate and duration
  double time = 0;            ///< s; fires at the first step at or after it
  Triple position{};          ///< m
  Triple velocity{};          ///< m/s, added to every particle's
  double source_radius = 0;   ///< m: ball of a burst, a point when zero; sphere of a shell
  Triple direction{0, 1, 0};  ///< of a cone or jet
  double half_angle = 0;      ///< rad, of a cone or jet
  Spread speed;               ///< m/s
  Spread mass{Spread::Kind::constant, 1, 0};  ///< kg
  Spread radius;                              ///< m
  /// m^2, or, with `drag_coefficient`, that times pi radius^2.
  Spread drag_area;
  std::optional<double> drag_coefficient;
  std::optional<Spread> life;  ///< s; none: for ever
  std::uint32_t group = 0;
  double rate = 0;      ///< 1/s, jet
  double duration = 0;  ///< s, jet
  double strength = 0;  ///< V0 of the book's explosion, m/s, whole
  /// degrees: 0 right, 90 up; none: all directions
  std::optional<double> angle;
  double life_ms = 4000;  ///< life of the book's explosion, ms
  double energy = 0;      ///< J, budget of an energy explosion
  LatticeKind lattice = LatticeKind::cubic;
  LatticeShape shape = LatticeShape::box;
  double spacing = 0;         ///< of the nearest sites of a lattice, m
  Triple size{};              ///< of a lattice's box about `position`, m
  double jitter = 0;          ///< greatest random displacement from a site along each axis, m
  Triple angular_velocity{};  ///< rad/s, of particles that touch
  EnergyShares shares = EnergyShares::equal;
};

/// An emitter with its times in steps.
class EmissionSchedule {
 public:
  EmissionSchedule(const Emitter& emitter, double t0, double dt);

  /// Particles emitted at steps before `step`.
  std::uint64_t emitted_before(std::int64_t step) const;
  /// The first step at or after `step` at which particles are emitted, or -1 when there is none.
  std::int64_t next(std::int64_t step) const;
  std::uint64_t total() const { return emitted_before(last_ + 1); }

 private:
  std::int64_t first_;
  std::int64_t last_;
  double per_step_;  ///< particles a step, jets
  std::uint64_t count_;
};

/// The first step whose time t0 + n dt is at or after `time` (within 1e-9 of a step). Steps start
/// at zero.
std::int64_t step_at(double time, double t0, double dt);

/// Sites that the lattice of an emitter has; its particles take the first `count` of them, from the
/// lowest layer up.
std::uint64_t lattice_sites(const Emitter& emitter);

/// Fills rows [first, first + count) of the table with the serials from `first_serial` on of this
/// emitter, born at `step`.
void emit(const Emitter& emitter, std::uint64_t seed, std::int64_t step, double dt,
          std::uint64_t first_serial, std::uint64_t count, soa::Table& table, std::size_t first,
          const Parallel& parallel);

}  // namespace salvo::solver
