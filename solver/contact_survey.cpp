#include "solver/contact_survey.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "kernels/sphere_contact.hpp"
#include "models/sweep.hpp"
#include "models/triangle_mesh.hpp"
#include "soa/array.hpp"
#include "soa/contact_fields.hpp"
#include "soa/particle_fields.hpp"
#include "solver/cell_grid.hpp"
#include "solver/contact_pass.hpp"
#include "solver/contact_rows.hpp"
#include "solver/reduction.hpp"
#include "solver/walls.hpp"
#include "solver/world.hpp"

namespace salvo::solver {

namespace {

using soa::ParticleField;
using S = kernels::ScalarLane<double>;
using Vec = kernels::Vec3<S>;

// Rows of neighboring cells that look for walls together.
constexpr std::size_t rows_per_look = 16;

template <class Field>
constexpr std::size_t index(Field field) {
  return static_cast<std::size_t>(field);
}

double root(double x) { return sqrt(S(x)).value(); }

// A column as numbers of double precision; a uniform value where there is none.
class Values {
 public:
  Values(const soa::Table& table, std::size_t field, std::size_t component = 0)
      : uniform_(table.uniform(field)) {
    if (!table.stored(field)) return;
    if (table.precision() == soa::Precision::float32) {
      single_ = table.column<float>(field, component);
    } else {
      twice_ = table.column<double>(field, component);
    }
  }
  double operator[](std::size_t row) const {
    return twice_ ? twice_[row] : single_ ? static_cast<double>(single_[row]) : uniform_;
  }

 private:
  const float* single_ = nullptr;
  const double* twice_ = nullptr;
  double uniform_;
};

struct Vectors {
  Values x, y, z;
  Vectors(const soa::Table& table, std::size_t field)
      : x(table, field, 0), y(table, field, 1), z(table, field, 2) {}
  double squared(std::size_t row) const {
    return x[row] * x[row] + y[row] * y[row] + z[row] * z[row];
  }
};

// Where the particles are, as exactly as it is known.
class Places {
 public:
  explicit Places(const soa::Table& table)
      : position_(table, index(ParticleField::position)),
        residual_(table, index(ParticleField::residual)),
        radius_(table, index(ParticleField::radius)) {}
  std::array<double, 3> center(std::size_t row) const {
    return {position_.x[row] + residual_.x[row], position_.y[row] + residual_.y[row],
            position_.z[row] + residual_.z[row]};
  }
  double radius(std::size_t row) const { return radius_[row]; }

 private:
  Vectors position_;
  Vectors residual_;
  Values radius_;
};

struct WallOverlap {
  double depth;  // positive where a particle overlaps a part of a wall, m
  Vec normal;    // towards the particle
};

WallOverlap wall_overlap(const Walls& walls, std::uint32_t number,
                         const std::array<double, 3>& center, double radius) {
  const WallPart part = walls.parts()[number];
  const models::Obstacle& shape = walls.now()[part.wall].shape;
  const Vec p{S(center[0] - shape.center[0]), S(center[1] - shape.center[1]),
              S(center[2] - shape.center[2])};
  if (shape.shape == models::ObstacleShape::mesh) {
    const std::array<double, 4>& q = shape.rotation;
    const kernels::Quat<S> turn{S(q[0]), S(q[1]), S(q[2]), S(q[3])};
    const auto at = feature_surface(*shape.mesh, part.feature, rotate(conjugate(turn), p));
    return {any(at.owns) ? radius - at.distance.value() : -1, rotate(turn, at.normal)};
  }
  if (shape.shape == models::ObstacleShape::height_field) {
    const auto field = models::field_surface(*shape.samples, p, S(radius));
    return {-field.distance.value(), field.normal};
  }
  const auto solid = models::solid_surface(shape, p);
  const double distance = solid.distance.value();
  if (shape.hollow) return {radius + distance, -solid.normal};
  return {radius - distance, solid.normal};
}

// What a particle overlaps.
struct Overlap {
  std::uint32_t partner;  // row, or part of a wall
  bool wall;
  double depth;  // m
};

// Finds the overlaps of all rows, or of those from one on with all.
class Search {
 public:
  Search(const soa::Table& particles, const Walls& walls, Isa isa, const Parallel& parallel,
         std::size_t first_row = 0)
      : places_(particles),
        ids_(particles.ids()),
        walls_(walls),
        kernels_(contact_kernels(isa)),
        parallel_(parallel),
        rows_(particles.rows()) {
    for (auto& column : columns_) column.resize(rows_ + room_of_a_pack);
    if (first_row > 0) find_vicinity(first_row);
    fill([](std::size_t i) { return i; });
    grid_.build(search_columns(), rows_, 0, 1, parallel_);
    fill([&](std::size_t i) { return grid_.order()[i]; });
  }

  /// Calls visit(task, row, overlaps) for every row: particles by ascending id, then walls by
  /// ascending part. Of the particles those for which counts(row, partner). Tasks run beside each
  /// other.
  template <class Counts, class Visit>
  void for_each_row(const Counts& counts, const Visit& visit) const {
    for_rows(parallel_, grid_.members(), [&](std::size_t first_of_task, std::size_t last) {
      const std::size_t task = first_of_task / rows_per_task;
      std::vector<std::uint32_t> near(64);
      std::vector<std::uint32_t> near_walls;
      std::vector<Overlap> overlaps;
      for (std::size_t first = first_of_task; first < last; first += rows_per_look) {
        const std::size_t end = std::min(last, first + rows_per_look);
        std::array<std::uint32_t, rows_per_look> listed;
        list(first, end, near, listed.data());
        Bounds bounds;
        for (std::size_t i = first; i < end; ++i) {
          bounds.add({columns_[0][i], columns_[1][i], columns_[2][i]}, columns_[3][i]);
        }
        near_walls.clear();
        walls_.near(bounds, 0, near_walls);
        const std::uint32_t* from = near.data();
        for (std::size_t i = first; i < end; ++i) {
          const std::size_t row = grid_.order()[i];
          overlaps.clear();
          for (const std::uint32_t* to = from + listed[i - first]; from < to; ++from) {
            const std::uint32_t other = grid_.order()[*from];
            if (!counts(row, other)) continue;
            const double depth = overlap(i, *from);
            if (depth > 0) overlaps.push_back({other, false, depth});
          }
          std::sort(overlaps.begin(), overlaps.end(),  // exact-set: ids are unique
                    [&](const Overlap& a, const Overlap& b) {
                      return ids_[a.partner] < ids_[b.partner];
                    });
          for (const std::uint32_t part : near_walls) {
            const double depth = wall_overlap(walls_, part, center(i), columns_[3][i]).depth;
            if (depth > 0) overlaps.push_back({part, true, depth});
          }
          visit(task, row, std::span<const Overlap>(overlaps));
        }
      }
    });
  }
  std::size_t tasks() const { return tasks_of(rows_, rows_per_task); }

 private:
  static constexpr std::size_t room_of_a_pack = 16;

  // Rows that none of those from first_row on can overlap are left out.
  void find_vicinity(std::size_t first_row) {
    double largest = 0;
    for (std::size_t row = 0; row < rows_; ++row) largest = std::max(largest, places_.radius(row));
    for (std::size_t c = 0; c < 3; ++c) std::swap(lowest_[c], highest_[c]);
    for (std::size_t row = first_row; row < rows_; ++row) {
      const auto center = places_.center(row);
      for (std::size_t c = 0; c < 3; ++c) {
        lowest_[c] = std::min(lowest_[c], center[c] - 2 * largest);
        highest_[c] = std::max(highest_[c], center[c] + 2 * largest);
      }
    }
  }

  // Of the i-th in the order of the cells; cells know no place beyond the farthest.
  std::array<double, 3> center(std::size_t i) const {
    const std::array<double, 3> seen{columns_[0][i], columns_[1][i], columns_[2][i]};
    for (const double coordinate : seen) {
      if (std::abs(coordinate) >= farthest_cell) return places_.center(grid_.order()[i]);
    }
    return seen;
  }
  // Positive where two particles overlap, m.
  double overlap(std::size_t i, std::size_t j) const {
    const auto a = center(i);
    const auto b = center(j);
    const double x = a[0] - b[0];
    const double y = a[1] - b[1];
    const double z = a[2] - b[2];
    return columns_[3][i] + columns_[3][j] - root(x * x + y * y + z * z);
  }

  template <class RowAt>
  void fill(const RowAt& row_at) {
    for_rows(parallel_, rows_, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const std::size_t row = row_at(i);
        const auto center = places_.center(row);
        bool inside = true;
        for (std::size_t c = 0; c < 3; ++c) {
          columns_[c][i] = seen_by_cells(center[c]);
          inside = inside && center[c] >= lowest_[c] && center[c] <= highest_[c];
        }
        columns_[3][i] = inside ? places_.radius(row) : -1;
      }
    });
  }
  SearchColumns search_columns() const {
    return {columns_[0].data(), columns_[1].data(), columns_[2].data(), columns_[3].data()};
  }
  void list(std::size_t first, std::size_t last, std::vector<std::uint32_t>& near,
            std::uint32_t* counts) const {
    ListPass pass;
    pass.first_row = first;
    pass.last_row = last;
    pass.index = grid_.index();
    pass.columns = search_columns();
    pass.owner = &near;
    pass.grow = [](void* owner, std::size_t& entries) {
      auto& list = *static_cast<std::vector<std::uint32_t>*>(owner);
      if (list.size() < entries) list.resize(entries + entries / 2);
      entries = list.size();
      return list.data();
    };
    pass.counts = counts;
    kernels_.list_neighbors(pass);
  }

  const Places places_;
  const soa::Id* ids_;
  const Walls& walls_;
  const ContactKernels& kernels_;
  const Parallel& parallel_;
  const std::size_t rows_;
  std::array<soa::Array<double>, 4> columns_;  // in the order of the cells
  static constexpr double most = std::numeric_limits<double>::max();
  std::array<double, 3> lowest_{-most, -most, -most};
  std::array<double, 3> highest_{most, most, most};
  CellGrid grid_;
};

// What the normal spring and the pull of a contact hold, J.
double elastic_energy(const models::ContactLaw& law, double overlap, double radius) {
  double stored = 0;
  switch (law.kind) {
    case models::ContactLawKind::linear_spring:
      stored = 0.5 * law.normal_stiffness * overlap * overlap;
      break;
    case models::ContactLawKind::hertz_mindlin:
      stored = kernels::HertzMindlin<S>{S(models::effective_young(law)), S(0), S(0)}
                   .elastic_energy(S(overlap), S(radius))
                   .value();
      break;
    case models::ContactLawKind::impulse:
      return 0;
  }
  return stored - 4 * kernels::pi * law.surface_energy * radius * overlap;
}

// The radius R* that a law takes for a pair.
double effective_radius(double a, double b) { return a * b / (a + b); }

struct Extremes {
  std::uint64_t pairs = 0;
  std::uint64_t walls = 0;
  double overlap = 0;
  double relative = 0;
};

Walls walls_at(const Setup& setup, double time) {
  Walls walls(setup.obstacles);
  walls.place(time);
  return walls;
}

}  // namespace

ContactDiagnostics diagnose_contacts(const Setup& setup, double time, const soa::Table& particles,
                                     Isa isa, const Parallel& parallel) {
  const models::ContactLaw& law = *setup.contact_law;
  const std::size_t rows = particles.rows();
  const Walls walls = walls_at(setup, time);
  const Places places(particles);
  ContactDiagnostics d;
  const auto zeros = [rows] {
    soa::Array<double> column;
    column.resize(rows);
    return column;
  };
  const auto sum_of_rows = [rows](const soa::Array<double>& column) {
    return fixed_order_sum({column.data(), rows});
  };
  soa::Array<double> sums = zeros();
  {
    soa::Array<double> relative = zeros();
    soa::Array<double> elastic = zeros();
    Extremes all;
    {
      const Search search(particles, walls, isa, parallel);
      std::vector<Extremes> extremes(search.tasks());
      // The lower id speaks for a pair; rows are in the order of the ids.
      const auto speaks = [](std::size_t row, std::size_t partner) { return row < partner; };
      search.for_each_row(
          speaks, [&](std::size_t task, std::size_t row, std::span<const Overlap> overlaps) {
            Extremes& most = extremes[task];
            for (const Overlap& overlap : overlaps) {
              const double own = places.radius(row);
              const double other = overlap.wall ? own : places.radius(overlap.partner);
              const double share = overlap.depth / std::min(own, other);
              ++(overlap.wall ? most.walls : most.pairs);
              most.overlap = std::max(most.overlap, overlap.depth);
              most.relative = std::max(most.relative, share);
              sums[row] += overlap.depth;
              relative[row] += share;
              elastic[row] += elastic_energy(law, overlap.depth,
                                             overlap.wall ? own : effective_radius(own, other));
            }
          });
      for (const Extremes& most : extremes) {
        all.pairs += most.pairs;
        all.walls += most.walls;
        all.overlap = std::max(all.overlap, most.overlap);
        all.relative = std::max(all.relative, most.relative);
      }
    }
    d.pair_contacts = all.pairs;
    d.wall_contacts = all.walls;
    d.max_overlap = all.overlap;
    d.max_relative_overlap = all.relative;
    const std::uint64_t contacts_found = all.pairs + all.walls;
    if (rows > 0) {
      d.mean_coordination = 2 * static_cast<double>(all.pairs) / static_cast<double>(rows);
    }
    if (contacts_found > 0) {
      d.mean_overlap = sum_of_rows(sums) / static_cast<double>(contacts_found);
      d.mean_relative_overlap = sum_of_rows(relative) / static_cast<double>(contacts_found);
    }
    d.elastic_energy = sum_of_rows(elastic);
  }

  const auto sum_of = [&](const auto& value) {
    for (std::size_t row = 0; row < rows; ++row) sums[row] = value(row);
    return sum_of_rows(sums);
  };
  if (law.turns()) {
    const Values mass(particles, index(ParticleField::mass));
    const Vectors spin(particles, index(ParticleField::angular_velocity));
    d.rotational_energy = sum_of([&](std::size_t row) {
      const double radius = places.radius(row);
      return 0.2 * mass[row] * radius * radius * spin.squared(row);
    });
  }
  const auto kept = [&](ParticleField field, std::size_t component = 0) {
    if (!law.energy_budget) return std::numeric_limits<double>::quiet_NaN();
    const Values values(particles, index(field), component);
    return sum_of([&](std::size_t row) { return values[row]; });
  };
  d.damping_loss = kept(ParticleField::damping_loss);
  d.friction_loss = kept(ParticleField::friction_loss);
  for (std::size_t c = 0; c < 3; ++c) {
    d.momentum_error[c] = kept(ParticleField::contact_impulse, c);
  }
  return d;
}

BirthOverlaps find_birth_overlaps(const Setup& setup, double time, const soa::Table& particles,
                                  std::size_t first_row, double tolerance, Isa isa,
                                  const Parallel& parallel) {
  const Walls walls = walls_at(setup, time);
  const Places places(particles);
  const soa::Id* ids = particles.ids();
  const Search search(particles, walls, isa, parallel, first_row);
  std::vector<BirthOverlaps> found(search.tasks());
  const auto place = [](const BirthOverlaps& o) {
    return std::pair(o.particle, o.obstacle ? soa::obstacle_partner(*o.obstacle) : o.partner);
  };
  const auto keep_worse = [&](BirthOverlaps& kept, const BirthOverlaps& other) {
    const std::uint64_t pairs = kept.pairs + other.pairs;
    // Of equals the first by id, whoever found it.
    if (other.pairs > 0 && (kept.pairs == 0 || other.worst > kept.worst ||
                            (other.worst == kept.worst && place(other) < place(kept)))) {
      kept = other;
    }
    kept.pairs = pairs;
  };
  const auto speaks = [&](std::size_t row, std::size_t partner) {
    return std::max(row, partner) >= first_row && ids[row] < ids[partner];
  };
  search.for_each_row(
      speaks, [&](std::size_t task, std::size_t row, std::span<const Overlap> overlaps) {
        for (const Overlap& overlap : overlaps) {
          const double own = places.radius(row);
          if (overlap.wall) {
            const double share = overlap.depth / own;
            if (row < first_row || share <= tolerance) continue;
            keep_worse(found[task], {1, share, ids[row], 0, walls.obstacle(overlap.partner)});
          } else {
            const double share = overlap.depth / std::min(own, places.radius(overlap.partner));
            if (share <= tolerance) continue;
            keep_worse(found[task], {1, share, ids[row], ids[overlap.partner], std::nullopt});
          }
        }
      });
  BirthOverlaps all;
  for (const BirthOverlaps& part : found) keep_worse(all, part);
  return all;
}

namespace {

template <class T>
void write_place(soa::Table& particles, std::size_t row, const std::array<double, 3>& place) {
  for (std::size_t c = 0; c < 3; ++c) {
    const T rounded = static_cast<T>(place[c]);
    particles.column<T>(index(ParticleField::position), c)[row] = rounded;
    if (T* residual = particles.column<T>(index(ParticleField::residual), c)) {
      residual[row] = static_cast<T>(place[c] - static_cast<double>(rounded));
    }
  }
}

}  // namespace

bool move_apart(const Setup& setup, double time, soa::Table& particles, std::size_t first_row,
                double tolerance, Isa isa, const Parallel& parallel) {
  constexpr int most_rounds = 1000;
  const Walls walls = walls_at(setup, time);
  const Places places(particles);
  const soa::Id* ids = particles.ids();
  const std::size_t rows = particles.rows();
  std::vector<std::uint32_t> overlapped(rows);
  std::vector<std::array<double, 3>> moved(rows - first_row);
  for (int round = 0; round < most_rounds; ++round) {
    const Search search(particles, walls, isa, parallel, first_row);
    std::vector<std::uint8_t> too_deep(search.tasks());
    const auto all = [](std::size_t, std::size_t) { return true; };
    search.for_each_row(
        all, [&](std::size_t task, std::size_t row, std::span<const Overlap> overlaps) {
          overlapped[row] = static_cast<std::uint32_t>(overlaps.size());
          if (row < first_row) return;
          for (const Overlap& overlap : overlaps) {
            const double own = places.radius(row);
            const double other = overlap.wall ? own : places.radius(overlap.partner);
            if (overlap.depth > tolerance * std::min(own, other)) too_deep[task] = 1;
          }
        });
    if (std::find(too_deep.begin(), too_deep.end(), 1) == too_deep.end()) return true;
    search.for_each_row(all, [&](std::size_t, std::size_t row, std::span<const Overlap> overlaps) {
      if (row < first_row) return;
      const auto center = places.center(row);
      Vec shift{S(0), S(0), S(0)};
      for (const Overlap& overlap : overlaps) {
        if (overlap.wall) {
          const auto wall = wall_overlap(walls, overlap.partner, center, places.radius(row));
          shift += wall.normal * S(wall.depth / overlapped[row]);
          continue;
        }
        const auto from = places.center(overlap.partner);
        const Vec offset{S(center[0] - from[0]), S(center[1] - from[1]), S(center[2] - from[2])};
        const double distance = norm(offset).value();
        // Two at the same place part along y, the lower id downwards.
        const Vec normal = distance > 0
                               ? offset * S(1 / distance)
                               : Vec{S(0), S(ids[row] < ids[overlap.partner] ? -1 : 1), S(0)};
        // A particle that is there already stays where it is.
        const double part = overlap.partner < first_row ? 1.0 : 0.5;
        const std::uint32_t most = std::max(overlapped[row], overlapped[overlap.partner]);
        shift += normal * S(part * overlap.depth / most);
      }
      moved[row - first_row] = {center[0] + shift.x.value(), center[1] + shift.y.value(),
                                center[2] + shift.z.value()};
    });
    for_rows(parallel, moved.size(), [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        if (particles.precision() == soa::Precision::float32) {
          write_place<float>(particles, first_row + i, moved[i]);
        } else {
          write_place<double>(particles, first_row + i, moved[i]);
        }
      }
    });
  }
  return false;
}

}  // namespace salvo::solver
