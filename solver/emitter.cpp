#include "solver/emitter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "kernels/random.hpp"
#include "soa/particle_fields.hpp"
#include "solver/parallel.hpp"
#include "solver/reduction.hpp"

namespace salvo::solver {

namespace {

using kernels::Draws;
using kernels::Vec3;
using S = kernels::ScalarLane<double>;
using soa::ParticleField;

// Draw numbers. Fixed for ever: changing one changes every bit of every scene.
namespace draw {
constexpr std::uint32_t direction = 0;
constexpr std::uint32_t place = 1;
constexpr std::uint32_t place_radius = 2;
constexpr std::uint32_t speed = 3;
constexpr std::uint32_t mass = 4;
constexpr std::uint32_t radius = 5;
constexpr std::uint32_t drag_area = 6;
constexpr std::uint32_t life = 7;
constexpr std::uint32_t share = 8;
constexpr std::uint32_t book_speed = 9;
constexpr std::uint32_t book_sign = 10;
constexpr std::uint32_t book_angle = 11;
constexpr std::uint32_t book_life = 12;
constexpr std::uint32_t jitter = 13;  // and the two after it
constexpr std::uint32_t stride = 16;  // distance of the repeated draws of a rejection
}  // namespace draw

constexpr std::size_t rows_per_task = 4096;

Vec3<double> vector(const Triple& triple) { return {triple[0], triple[1], triple[2]}; }

double sample(const Spread& spread, const Draws& draws, std::uint32_t number) {
  switch (spread.kind) {
    case Spread::Kind::constant:
      return spread.a;
    case Spread::Kind::uniform:
      return draws.uniform(number, spread.a, spread.b);
    case Spread::Kind::normal: {
      const double low = std::max(spread.a - 4 * spread.b, std::numeric_limits<double>::min());
      return draws.truncated_normal(number, draw::stride, spread.a, spread.b, low,
                                    spread.a + 4 * spread.b);
    }
  }
  return spread.a;
}

struct Newborn {
  Vec3<double> position;
  Vec3<double> velocity;
  double mass;
  double radius;
  double drag_area;
  std::int32_t death;
};

std::int32_t death_step(std::int64_t birth, double life, double dt) {
  const double steps = std::max(1.0, ceil(S(life / dt - 1e-9)).value());
  const double death = static_cast<double>(birth) + steps;
  return death >= static_cast<double>(soa::never) ? soa::never : static_cast<std::int32_t>(death);
}

// Bourg & Bywalec 2.6: whole-number draws, both ends included; y is up here.
void book_explosion(const Emitter& emitter, const Draws& draws, std::int64_t step, double dt,
                    Newborn& born) {
  const auto strength = static_cast<std::int64_t>(emitter.strength);
  const auto speed = static_cast<double>(draws.integer(draw::book_speed, strength / 2, strength));
  double degrees;
  if (emitter.angle) {
    const double sign = draws.integer(draw::book_sign, 0, 1) == 0 ? -1 : 1;
    degrees = *emitter.angle - sign * static_cast<double>(draws.integer(draw::book_angle, 0, 10));
  } else {
    degrees = static_cast<double>(draws.integer(draw::book_angle, 0, 360));
  }
  const S angle(degrees * (kernels::pi / 180));
  born.velocity = Vec3<double>{speed * cos(angle).value(), speed * sin(angle).value(), 0};
  const auto percent = static_cast<double>(draws.integer(draw::book_life, 80, 100));
  const double life = round(S(emitter.life_ms * percent / 100)).value() * 1e-3;
  born.death = death_step(step, life, dt);
}

// Calls visit(site) for the sites of a lattice, relative to the middle of its box, from the lowest
// layer up, each layer in rows along x.
template <class Visit>
void for_each_site(const Emitter& emitter, const Visit& visit) {
  const bool dense = emitter.lattice == LatticeKind::close_packed;
  const double a = emitter.spacing;
  const double row_step = dense ? a * sqrt(S(0.75)).value() : a;
  const double layer_step = dense ? a * sqrt(S(2.0 / 3.0)).value() : a;
  const auto along = [](double length, double step) {
    return static_cast<std::int64_t>(floor(S(length / step + 1e-9)).value()) + 1;
  };
  // Sites keep half a spacing from the faces of the box.
  const Vec3<double> room{emitter.size[0] - a, emitter.size[1] - a, emitter.size[2] - a};
  if (room.x < 0 || room.y < 0 || room.z < 0) return;
  const std::int64_t layers = along(room.y, layer_step);
  for (std::int64_t k = 0; k < layers; ++k) {
    // Every other layer lies in the hollows of the one below, every other row between the sites.
    const double z_shift = dense && k % 2 == 1 ? row_step / 3 : 0;
    const double y = -0.5 * room.y + static_cast<double>(k) * layer_step;
    for (std::int64_t j = 0; j < along(room.z - z_shift, row_step); ++j) {
      const double x_shift = dense && (j + k) % 2 == 1 ? 0.5 * a : 0;
      const double z = -0.5 * room.z + z_shift + static_cast<double>(j) * row_step;
      for (std::int64_t i = 0; i < along(room.x - x_shift, a); ++i) {
        const double x = -0.5 * room.x + x_shift + static_cast<double>(i) * a;
        const double u = 2 * x / emitter.size[0];
        const double v = 2 * y / emitter.size[1];
        const double w = 2 * z / emitter.size[2];
        const double across = u * u + w * w;
        const double radius = 0.5 * (1 - v);  // of a cone at this height
        if (emitter.shape == LatticeShape::ellipsoid && across + v * v > 1) continue;
        if (emitter.shape == LatticeShape::cone && across > radius * radius) continue;
        visit(Vec3<double>{x, y, z});
      }
    }
  }
}

// Uniform within a ball about the origin.
Vec3<double> in_ball(double radius, const Draws& draws) {
  if (!(radius > 0)) return {0, 0, 0};
  const double r = radius * cbrt(S(draws.uniform(draw::place_radius))).value();
  return draws.on_sphere(draw::place) * r;
}

Newborn newborn(const Emitter& emitter, const Draws& draws, std::int64_t step, double dt) {
  Newborn born;
  born.mass = sample(emitter.mass, draws, draw::mass);
  born.radius = sample(emitter.radius, draws, draw::radius);
  born.drag_area = emitter.drag_coefficient
                       ? *emitter.drag_coefficient * (kernels::pi * born.radius * born.radius)
                       : sample(emitter.drag_area, draws, draw::drag_area);
  born.death =
      emitter.life ? death_step(step, sample(*emitter.life, draws, draw::life), dt) : soa::never;
  born.position = {0, 0, 0};
  const double speed = sample(emitter.speed, draws, draw::speed);
  switch (emitter.kind) {
    case EmitterKind::burst:
    case EmitterKind::energy_explosion:
      born.velocity = draws.on_sphere(draw::direction) * speed;
      born.position = in_ball(emitter.source_radius, draws);
      break;
    case EmitterKind::shell: {
      const Vec3<double> outward = draws.on_sphere(draw::direction);
      born.position = outward * emitter.source_radius;
      born.velocity = outward * speed;
      break;
    }
    case EmitterKind::cone:
    case EmitterKind::jet:
      born.velocity =
          draws.in_cone(draw::direction, vector(emitter.direction), emitter.half_angle) * speed;
      born.position = in_ball(emitter.source_radius, draws);
      break;
    case EmitterKind::book_explosion:
      book_explosion(emitter, draws, step, dt, born);
      break;
    case EmitterKind::lattice:
      born.velocity = draws.on_sphere(draw::direction) * speed;
      if (emitter.jitter > 0) {
        born.position = {draws.uniform(draw::jitter, -emitter.jitter, emitter.jitter),
                         draws.uniform(draw::jitter + 1, -emitter.jitter, emitter.jitter),
                         draws.uniform(draw::jitter + 2, -emitter.jitter, emitter.jitter)};
      }
      break;
  }
  born.position += vector(emitter.position);
  born.velocity += vector(emitter.velocity);
  return born;
}

// Speeds of an energy explosion, one a particle: sum of m v^2 / 2 <= energy.
std::vector<double> energy_speeds(const Emitter& emitter, std::uint64_t seed,
                                  std::uint64_t first_serial, std::span<const double> masses) {
  const std::size_t n = masses.size();
  const auto draws = [&](std::size_t i) {
    return Draws(seed, soa::make_id(emitter.stream, first_serial + i));
  };
  std::vector<double> speeds(n);
  if (emitter.shares == EnergyShares::book) {
    double left = emitter.energy;
    for (std::size_t i = 0; i < n; ++i) {
      const double fastest = sqrt(S(2 * left / masses[i])).value();
      speeds[i] = draws(i).uniform(draw::share) * fastest;
      left = std::max(0.0, left - 0.5 * masses[i] * speeds[i] * speeds[i]);
    }
    return speeds;
  }
  std::vector<double> shares(n, 1.0);
  for (std::size_t i = 0; i < n; ++i) {
    if (emitter.shares == EnergyShares::uniform) {
      shares[i] = draws(i).uniform(draw::share);
    } else if (emitter.shares == EnergyShares::normal) {
      shares[i] = draws(i).truncated_normal(draw::share, draw::stride, 1.0, 0.25, 0.0, 2.0);
    }
  }
  // A little under the budget, so that the roundings below cannot carry the sum over it.
  const double each = emitter.energy * (1 - 0x1p-40) / fixed_order_sum(shares);
  for (std::size_t i = 0; i < n; ++i) speeds[i] = sqrt(S(2 * each * shares[i] / masses[i])).value();
  return speeds;
}

// To the column's precision; `toward_zero` never rounds a magnitude up.
template <class T>
T rounded(double value, bool toward_zero) {
  const T nearest = static_cast<T>(value);
  if (toward_zero && std::abs(static_cast<double>(nearest)) > std::abs(value)) {
    return std::nextafter(nearest, T(0));
  }
  return nearest;
}

template <class T>
void store(soa::Table& table, ParticleField which, std::size_t component, std::size_t row,
           double value, bool toward_zero = false) {
  T* column = table.column<T>(static_cast<std::size_t>(which), component);
  if (column) column[row] = rounded<T>(value, toward_zero);
}

template <class T>
void emit_rows(const Emitter& emitter, std::uint64_t seed, std::int64_t step, double dt,
               std::uint64_t first_serial, std::uint64_t count, soa::Table& table,
               std::size_t first, const Parallel& parallel) {
  std::vector<double> speeds;
  const bool budget = emitter.kind == EmitterKind::energy_explosion;
  if (budget) {
    std::vector<double> masses(count);
    for (std::size_t i = 0; i < count; ++i) {
      const Draws draws(seed, soa::make_id(emitter.stream, first_serial + i));
      // The mass that is stored, so that the budget holds for it; rounded as in the table.
      masses[i] = static_cast<double>(static_cast<T>(sample(emitter.mass, draws, draw::mass)));
    }
    speeds = energy_speeds(emitter, seed, first_serial, masses);
  }
  std::vector<Vec3<double>> sites;
  if (emitter.kind == EmitterKind::lattice) {
    std::uint64_t serial = 0;
    sites.reserve(count);
    for_each_site(emitter, [&](const Vec3<double>& site) {
      if (serial >= first_serial && serial < first_serial + count) sites.push_back(site);
      ++serial;
    });
  }
  const std::size_t tasks = (count + rows_per_task - 1) / rows_per_task;
  parallel.for_each(tasks, [&](std::size_t task) {
    const std::size_t last = std::min<std::size_t>(count, (task + 1) * rows_per_task);
    for (std::size_t i = task * rows_per_task; i < last; ++i) {
      const soa::Id id = soa::make_id(emitter.stream, first_serial + i);
      const Draws draws(seed, id);
      Newborn born = newborn(emitter, draws, step, dt);
      if (budget) born.velocity = draws.on_sphere(draw::direction) * (speeds[i] * (1 - 0x1p-50));
      if (!sites.empty()) born.position += sites[i];
      const std::size_t row = first + i;
      table.ids()[row] = id;
      const double place[3] = {born.position.x, born.position.y, born.position.z};
      for (std::size_t c = 0; c < 3; ++c) {
        store<T>(table, ParticleField::position, c, row, place[c]);
        if constexpr (sizeof(T) == 4) {
          const auto held = static_cast<double>(rounded<T>(place[c], false));
          store<T>(table, ParticleField::residual, c, row, place[c] - held);
        }
      }
      store<T>(table, ParticleField::velocity, 0, row, born.velocity.x, budget);
      store<T>(table, ParticleField::velocity, 1, row, born.velocity.y, budget);
      store<T>(table, ParticleField::velocity, 2, row, born.velocity.z, budget);
      for (std::size_t c = 0; c < 3; ++c) {
        store<T>(table, ParticleField::angular_velocity, c, row, emitter.angular_velocity[c]);
      }
      store<T>(table, ParticleField::mass, 0, row, born.mass);
      store<T>(table, ParticleField::radius, 0, row, born.radius);
      store<T>(table, ParticleField::drag_area, 0, row, born.drag_area);
      const auto integer = [&]<class I>(ParticleField which, I value) {
        I* column = table.column<I>(static_cast<std::size_t>(which));
        if (column) column[row] = value;
      };
      integer(ParticleField::birth, static_cast<std::int32_t>(step));
      integer(ParticleField::death, born.death);
      integer(ParticleField::group, emitter.group);
    }
  });
}

}  // namespace

std::int64_t step_at(double time, double t0, double dt) {
  return static_cast<std::int64_t>(std::max(0.0, ceil(S((time - t0) / dt - 1e-9)).value()));
}

EmissionSchedule::EmissionSchedule(const Emitter& emitter, double t0, double dt)
    : first_(step_at(emitter.time, t0, dt)), last_(first_), per_step_(0), count_(emitter.count) {
  if (emitter.kind == EmitterKind::jet) {
    per_step_ = emitter.rate * dt;
    count_ = static_cast<std::uint64_t>(floor(S(emitter.rate * emitter.duration + 1e-9)).value());
    last_ = count_ == 0 ? first_
                        : first_ + static_cast<std::int64_t>(
                                       ceil(S(static_cast<double>(count_) / per_step_)).value());
  }
}

std::uint64_t EmissionSchedule::emitted_before(std::int64_t step) const {
  if (step <= first_) return 0;
  if (per_step_ == 0 || step > last_) return count_;
  const double due = floor(S(per_step_ * static_cast<double>(step - first_))).value();
  return std::min(count_, static_cast<std::uint64_t>(due));
}

std::int64_t EmissionSchedule::next(std::int64_t step) const {
  std::int64_t low = std::max(step, first_);
  if (low > last_ || emitted_before(low) == count_) return -1;
  // The first step after which more have been emitted than before `low`: emitted_before never
  // falls.
  const std::uint64_t before = emitted_before(low);
  std::int64_t high = last_;
  while (low < high) {
    const std::int64_t middle = low + (high - low) / 2;
    if (emitted_before(middle + 1) > before) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return low;
}

std::uint64_t lattice_sites(const Emitter& emitter) {
  std::uint64_t sites = 0;
  for_each_site(emitter, [&](const Vec3<double>&) { ++sites; });
  return sites;
}

void emit(const Emitter& emitter, std::uint64_t seed, std::int64_t step, double dt,
          std::uint64_t first_serial, std::uint64_t count, soa::Table& table, std::size_t first,
          const Parallel& parallel) {
  if (table.precision() == soa::Precision::float32) {
    emit_rows<float>(emitter, seed, step, dt, first_serial, count, table, first, parallel);
  } else {
    emit_rows<double>(emitter, seed, step, dt, first_serial, count, table, first, parallel);
  }
}

}  // namespace salvo::solver
