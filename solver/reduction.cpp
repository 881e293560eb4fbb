#include "solver/reduction.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "kernels/lane.hpp"
#include "soa/particle_fields.hpp"

namespace salvo::solver {

namespace {

using S = kernels::ScalarLane<double>;

double plain_sqrt(double x) { return sqrt(S(x)).value(); }

constexpr std::size_t sums = 9;  // mass, momentum 3, first moment 3, kinetic, potential

// The running totals of one virtual lane, one leaf, or all.
struct Totals {
  std::array<double, sums> sum{};
  std::array<double, 3> lowest;
  std::array<double, 3> highest;
  double max_speed_squared = 0;

  Totals() {
    lowest.fill(std::numeric_limits<double>::infinity());
    highest.fill(-std::numeric_limits<double>::infinity());
  }
  void add(const Totals& other) {
    for (std::size_t i = 0; i < sums; ++i) sum[i] += other.sum[i];
    for (std::size_t c = 0; c < 3; ++c) {
      lowest[c] = std::min(lowest[c], other.lowest[c]);
      highest[c] = std::max(highest[c], other.highest[c]);
    }
    max_speed_squared = std::max(max_speed_squared, other.max_speed_squared);
  }
};

// Combines neighbours, then neighbours of those, ..: the shape depends on the count alone.
template <class Value, class Add>
Value tree(std::vector<Value>& values, Add add) {
  if (values.empty()) return Value{};
  for (std::size_t span = 1; span < values.size(); span *= 2) {
    for (std::size_t i = 0; i + span < values.size(); i += 2 * span)
      add(values[i], values[i + span]);
  }
  return values.front();
}

template <class T>
struct Columns {
  const T* position[3];
  const T* velocity[3];
  const T* mass;
  double uniform_mass;

  explicit Columns(const soa::Table& table) {
    using soa::ParticleField;
    const auto at = [](ParticleField f) { return static_cast<std::size_t>(f); };
    for (std::size_t c = 0; c < 3; ++c) {
      position[c] = table.column<T>(at(ParticleField::position), c);
      velocity[c] = table.column<T>(at(ParticleField::velocity), c);
    }
    mass = table.column<T>(at(ParticleField::mass));
    uniform_mass = table.uniform(at(ParticleField::mass));
  }
};

double potential(const models::ForceSettings& forces, const std::array<double, 3>& x) {
  double energy = -(forces.gravity[0] * x[0] + forces.gravity[1] * x[1] + forces.gravity[2] * x[2]);
  for (const models::PointGravity& pull : forces.point_gravity) {
    double r2 = pull.softening * pull.softening;
    for (std::size_t c = 0; c < 3; ++c) {
      const double d = x[c] - pull.center[c];
      r2 += d * d;
    }
    if (r2 > 0) energy -= pull.strength / plain_sqrt(r2);
  }
  return energy;
}

template <class T>
Totals leaf_totals(const Columns<T>& columns, const models::ForceSettings& forces,
                   std::size_t first, std::size_t last) {
  std::vector<Totals> lanes(virtual_lanes);
  for (std::size_t row = first; row < last; ++row) {
    Totals& lane = lanes[(row - first) % virtual_lanes];
    std::array<double, 3> x;
    std::array<double, 3> v;
    for (std::size_t c = 0; c < 3; ++c) {
      x[c] = static_cast<double>(columns.position[c][row]);
      v[c] = static_cast<double>(columns.velocity[c][row]);
    }
    const double m = columns.mass ? static_cast<double>(columns.mass[row]) : columns.uniform_mass;
    const double v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    lane.sum[0] += m;
    for (std::size_t c = 0; c < 3; ++c) {
      lane.sum[1 + c] += m * v[c];
      lane.sum[4 + c] += m * x[c];
      lane.lowest[c] = std::min(lane.lowest[c], x[c]);
      lane.highest[c] = std::max(lane.highest[c], x[c]);
    }
    lane.sum[7] += 0.5 * m * v2;
    lane.sum[8] += m * potential(forces, x);
    lane.max_speed_squared = std::max(lane.max_speed_squared, v2);
  }
  return tree(lanes, [](Totals& a, const Totals& b) { a.add(b); });
}

template <class T>
Totals totals(const soa::Table& table, const models::ForceSettings& forces,
              const Parallel& parallel) {
  const Columns<T> columns(table);
  std::vector<Totals> leaves((table.rows() + leaf_rows - 1) / leaf_rows);
  parallel.for_each(leaves.size(), [&](std::size_t leaf) {
    leaves[leaf] = leaf_totals(columns, forces, leaf * leaf_rows,
                               std::min(table.rows(), (leaf + 1) * leaf_rows));
  });
  return tree(leaves, [](Totals& a, const Totals& b) { a.add(b); });
}

}  // namespace

double fixed_order_sum(std::span<const double> values) {
  std::vector<double> leaves;
  for (std::size_t first = 0; first < values.size(); first += leaf_rows) {
    std::vector<double> lanes(virtual_lanes, 0.0);
    const std::size_t last = std::min(values.size(), first + leaf_rows);
    for (std::size_t i = first; i < last; ++i) lanes[(i - first) % virtual_lanes] += values[i];
    leaves.push_back(tree(lanes, [](double& a, double b) { a += b; }));
  }
  return tree(leaves, [](double& a, double b) { a += b; });
}

Diagnostics diagnose(const soa::Table& particles, const models::ForceSettings& forces,
                     const Parallel& parallel) {
  const Totals total = particles.precision() == soa::Precision::float32
                           ? totals<float>(particles, forces, parallel)
                           : totals<double>(particles, forces, parallel);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Diagnostics d;
  d.count = particles.rows();
  d.mass = total.sum[0];
  for (std::size_t c = 0; c < 3; ++c) {
    d.momentum[c] = total.sum[1 + c];
    d.center_of_mass[c] = d.mass > 0 ? total.sum[4 + c] / d.mass : nan;
    d.lowest[c] = d.count == 0 ? nan : total.lowest[c];
    d.highest[c] = d.count == 0 ? nan : total.highest[c];
  }
  d.kinetic_energy = total.sum[7];
  d.potential_energy = total.sum[8];
  d.max_speed = plain_sqrt(total.max_speed_squared);
  return d;
}

}  // namespace salvo::solver
