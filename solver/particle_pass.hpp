// A pass: the steps a tile of particles takes before it goes back to memory. Plain data only,
// because it crosses from the ordinary translation units to the kernels of one instruction set.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "models/force_settings.hpp"
#include "models/obstacle.hpp"
#include "solver/isa.hpp"

namespace salvo::solver {

enum class IntegratorKind {
  explicit_euler,
  semi_implicit_euler,
  improved_euler,
  runge_kutta_4,
  velocity_verlet,
};

/// The box in which particles may be. Unbounded unless a scene says otherwise.
struct Domain {
  bool bounded = false;
  models::Triple lowest{};
  models::Triple highest{};
};

/// Whole-number results of a pass; they add up in any order.
struct ContactTally {
  std::uint64_t impacts = 0;
  std::uint64_t rests = 0;  ///< steps that ended at rest or sliding on the surface, impacts used up
};

/// Rows [first_row, last_row) of the columns; first_row is a multiple of 64 and the columns are
/// padded to 64 rows. A null parameter column means the uniform value.
template <class T>
struct ParticlePass {
  std::size_t first_row = 0;
  std::size_t last_row = 0;
  T* position[3] = {};
  T* velocity[3] = {};
  const T* mass = nullptr;
  const T* radius = nullptr;
  const T* drag_area = nullptr;
  const std::int32_t* death = nullptr;
  T uniform_mass = 1;
  T uniform_radius = 0;
  T uniform_drag_area = 0;

  std::int32_t first_step = 0;
  std::int32_t steps = 1;
  T dt = 0;
  IntegratorKind integrator = IntegratorKind::semi_implicit_euler;
  const models::ForceSettings* forces = nullptr;
  std::span<const models::Obstacle> obstacles;
  models::ContactSettings contact;
  Domain domain;
  /// Coefficients of the instants t_n, t_n + dt/2, t_n + dt, t_n + 3dt/2, ..: 2 steps + 1 entries
  /// of `instant_stride`.
  const T* instants = nullptr;
  std::size_t instant_stride = 0;

  /// Store rows that went bad too (used to look at them step by step).
  bool keep_bad = false;
  /// One word for each block of 64 rows from first_row: rows that were left as they were at the
  /// start of the pass, because one of them, or a neighbour in its pack, became non-finite or left
  /// the domain.
  std::uint64_t* unsaved = nullptr;
  ContactTally tally;
  std::uint64_t steps_taken = 0;  ///< by live particles, together
};

/// The kernels of one instruction set.
struct ParticleKernels {
  void (*advance_float32)(ParticlePass<float>&);
  void (*advance_float64)(ParticlePass<double>&);
};

/// Throws std::invalid_argument when the binary lacks the instruction set.
const ParticleKernels& particle_kernels(Isa isa);

}  // namespace salvo::solver
