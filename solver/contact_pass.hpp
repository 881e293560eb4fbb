// A step of particles that touch: the rows of one task, with their neighbor lists. Plain data only,
// because it crosses from the ordinary translation units to the kernels of one instruction set.
//
// Rows are in an order of the broad phase's choice, in groups of 16 whose lists lie side by side:
// slot s of a group holds the s-th neighbor of each of its rows, by ascending id. A row of fewer
// neighbors has `nowhere` in the remaining slots, a row that touches nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "models/contact_law.hpp"
#include "models/force_settings.hpp"
#include "models/obstacle.hpp"
#include "solver/cell_grid.hpp"
#include "solver/isa.hpp"
#include "solver/particle_pass.hpp"

namespace salvo::solver {

/// Rows whose lists lie side by side: the lanes of the widest pack.
inline constexpr std::size_t group_rows = 16;

/// Where a particle is: all that it takes to see that two are far from touching. Most neighbors
/// are, and are anywhere in memory, so this is apart and small.
template <class T>
struct alignas(4 * sizeof(T)) SpherePlace {
  T position[3];  // m
  T radius;       // m; negative: gone, touches nothing
};

/// What contacts need besides.
template <class T>
struct alignas(4 * sizeof(T)) SphereMotion {
  T residual[3];  // what rounding left out of the position, m; zero in double precision
  T mass;         // kg
  T velocity[3];  // m/s
  T path;         // length gone since the lists were built, m
  T spin[3];      // rad/s
  T padding;
};

/// Rows of particles.
template <class Place, class Motion>
struct SphereRows {
  Place* place = nullptr;
  Motion* motion = nullptr;
};

/// The radius of a row that touches nothing.
inline constexpr double no_radius = -1e30;
/// Where the row that fills up lists is: no overlap, and squares that do not overflow.
inline constexpr double nowhere_position = 1e18;

/// The displacements that the contacts of a task remember, as columns: three numbers, six where
/// rolling resists. Contacts follow one another by slots and, within one, by lanes.
template <class T>
struct ContactHistory {
  std::uint16_t* touching = nullptr;  // which lanes of a slot touched at the last step; null: none
  const T* before = nullptr;          // columns of `count_before`
  std::size_t count_before = 0;
  T* after = nullptr;  // columns of `room`, at least one for each entry of the lists
  std::size_t room = 0;
  std::size_t count = 0;  ///< a result: contacts after the step
};

/// What the slots of the walls remember: which rows touched at the last step, as bits, and three
/// packs of 16 for each displacement. Null where the law needs none.
template <class T>
struct WallMemory {
  std::uint16_t* touching = nullptr;
  T* tangential = nullptr;
  T* rolling = nullptr;
};

/// What a sphere touches at one point: a wall, or one feature of a wall that is a mesh.
struct WallPart {
  std::uint32_t wall;
  std::uint32_t feature;
};

/// An obstacle, or a smooth part of one, as it stands in this step.
struct Wall {
  models::Obstacle shape;
  models::Triple velocity{};          // of the shape's center, m/s
  models::Triple angular_velocity{};  // rad/s
  double damping_ratio = 0;
  models::Triple center_rest{};  // of the center less the center as a float, m
};

template <class T>
struct ContactPass {
  std::size_t first_group = 0;
  std::size_t last_group = 0;
  SphereRows<const SpherePlace<T>, const SphereMotion<T>> from;
  SphereRows<SpherePlace<T>, SphereMotion<T>> to;
  const std::uint64_t* first_slot = nullptr;  // of each group and, last, their number
  const std::int32_t* neighbor = nullptr;     // rows, slot after slot of 16
  ContactHistory<T> history;
  const std::uint64_t* first_wall_slot = nullptr;  // likewise
  const std::uint32_t* wall_part = nullptr;        // one for all rows of a slot
  WallMemory<T> wall_memory;
  std::span<const Wall> walls;
  std::span<const WallPart> wall_parts;

  const T* drag_area = nullptr;
  const std::int32_t* death = nullptr;
  T* damping_loss = nullptr;  // J, summed over the run; null, as those below: no budget
  T* friction_loss = nullptr;
  T* contact_impulse[3] = {nullptr, nullptr, nullptr};  // N s, of other particles
  T* approaches = nullptr;  // contacts of each row whose partners come nearer: the impulse law's
  T uniform_drag_area = 0;
  bool equal = false;  // all particles have the mass and radius below
  T uniform_mass = 1;
  T uniform_radius = 0;

  std::int32_t step = 0;
  T dt = 0;
  const models::ContactLaw* law = nullptr;
  double damping_ratio = 0;
  const models::ForceSettings* forces = nullptr;
  const T* instants = nullptr;
  Domain domain;

  // Results.
  double longest_path = 0;        ///< m, of a row since the lists were built
  std::uint64_t steps_taken = 0;  ///< rows that lived
  bool bad = false;               ///< a row is not finite or out of the domain
};

/// Which entries of the lists of some groups are within a margin of touching.
template <class T>
struct PrunePass {
  std::size_t first_group = 0;
  std::size_t last_group = 0;
  const SpherePlace<T>* place = nullptr;
  const std::uint64_t* first_slot = nullptr;  // of each group and, last, their number
  const std::int32_t* neighbor = nullptr;
  T margin = 0;                   // m
  std::uint16_t* near = nullptr;  ///< a result: the rows of each slot, as bits
};

/// The lists of rows in the order of the cells, as runs of such rows.
struct ListPass {
  std::size_t first_row = 0;
  std::size_t last_row = 0;
  CellIndex index;
  SearchColumns columns;  // in the order of the cells, with room for a pack more at the end
  double margin = 0;      // m
  /// Makes room for so many entries or more, and says for how many; returns where they begin, which
  /// holds what was written.
  std::uint32_t* (*grow)(void* owner, std::size_t& entries) = nullptr;
  void* owner = nullptr;
  std::uint32_t* counts = nullptr;  // of each row from first_row
  std::size_t entries = 0;          ///< written, together
};

/// The kernels of one instruction set.
struct ContactKernels {
  void (*list_neighbors)(ListPass&);
  void (*prune_float32)(PrunePass<float>&);
  void (*prune_float64)(PrunePass<double>&);
  void (*advance_float32)(ContactPass<float>&);
  void (*advance_float64)(ContactPass<double>&);
  /// Of the impulse law, before the step: fills `approaches`.
  void (*count_float32)(ContactPass<float>&);
  void (*count_float64)(ContactPass<double>&);
};

/// Throws std::invalid_argument when the binary lacks the instruction set.
const ContactKernels& contact_kernels(Isa isa);

}  // namespace salvo::solver
