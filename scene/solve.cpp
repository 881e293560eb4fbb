#include "scene/solve.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

namespace salvo::scene {

namespace {

constexpr std::uint64_t parts = 64;

// A distribution moves as a whole.
void set_nominal(solver::SweepSetup& setup, std::size_t input, double value) {
  solver::Variation& varies = setup.inputs[input];
  const double by = value - varies.nominal();
  varies.lowest += by;
  varies.highest += by;
  if (varies.kind == solver::Variation::Kind::uniform) {
    varies.a += by;
    varies.b += by;
  } else {
    varies.a = value;
  }
  for (solver::JointNormal& joint : setup.joint) {
    for (std::size_t k = 0; k < joint.inputs.size(); ++k) {
      if (joint.inputs[k] == input) joint.mean[k] = value;
    }
  }
}

std::vector<double> values_between(double low, double high) {
  std::vector<double> values;
  for (std::uint64_t i = 0; i <= parts; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(parts);
    values.push_back(i == parts ? high : low + (high - low) * part);
  }
  return values;
}

// The quantity less its target for a value of the input, and how the trajectory ended.
struct Residual {
  double left;
  std::uint32_t outcome;
};

std::vector<Residual> residuals(const Equation& equation, const solver::SweepSetup& setup,
                                const std::vector<double>& values) {
  solver::SweepSetup batch = nominal(setup);
  batch.precision = soa::Precision::float64;
  batch.integration.samples = {};
  for (const auto& [input, value] : equation.with) {
    batch.inputs[input] = solver::Variation::of(value);
  }
  solver::Variation& axis = batch.inputs[equation.input];
  axis.kind = solver::Variation::Kind::grid;
  axis.values = values;
  const solver::Sweep sweep(std::move(batch));
  const solver::SweepRows rows = sweep.run(0, values.size(), {solver::widest_isa(), 1, 1});
  const auto is_outcome = [](const soa::Field& field) { return field.name == "outcome"; };
  const auto outcome = std::ranges::find_if(sweep.fields(), is_outcome) - sweep.fields().begin();
  const std::uint32_t* ended = rows.table.column<std::uint32_t>(static_cast<std::size_t>(outcome));
  const double* column = rows.table.column<double>(equation.column);
  const std::size_t time_limit = setup.model(solver::Isa::scalar).events.size();
  std::vector<Residual> residual;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double value = column ? column[i] : rows.table.uniform(equation.column);
    // A trajectory that broke off is no answer, whatever it was to bring about.
    const bool counts = equation.outcome ? ended[i] == *equation.outcome : ended[i] <= time_limit;
    residual.push_back(
        {counts ? value - equation.target : std::numeric_limits<double>::quiet_NaN(), ended[i]});
  }
  return residual;
}

bool changes_sign(const Residual& a, const Residual& b) {
  return (a.left <= 0 && b.left >= 0) || (a.left >= 0 && b.left <= 0);
}

// The part of the bracket over which the residual changes its sign, between trajectories that end
// alike: one that comes down early is at the ground, whatever it was to reach.
std::optional<std::size_t> crossing(const std::vector<Residual>& residual, bool last) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i + 1 < residual.size(); ++i) {
    if (residual[i].outcome != residual[i + 1].outcome) continue;
    if (!changes_sign(residual[i], residual[i + 1])) continue;
    found = i;
    if (!last) break;
  }
  return found;
}

// Trajectories that end at the target whatever the input is, such as on the ground: several values
// in a row that bring the quantity there, or a change of sign that is one of how they end.
bool is_pinned(const std::vector<Residual>& residual) {
  double largest = 0;
  for (const Residual& r : residual) {
    if (std::isfinite(r.left)) largest = std::max(largest, std::abs(r.left));
  }
  const auto there = [&](const Residual& r) { return std::abs(r.left) <= 1e-11 * largest; };
  for (std::size_t i = 0; i + 1 < residual.size(); ++i) {
    const bool alike = residual[i].outcome == residual[i + 1].outcome;
    if (alike ? there(residual[i]) && there(residual[i + 1])
              : changes_sign(residual[i], residual[i + 1])) {
      return true;
    }
  }
  return false;
}

std::optional<Unsolved> solve_one(Equation& equation, const solver::SweepSetup& setup) {
  double low = equation.between[0];
  double high = equation.between[1];
  for (int round = 0;; ++round) {
    const std::vector<double> values = values_between(low, high);
    const std::vector<Residual> residual = residuals(equation, setup, values);
    if (round == 0 && is_pinned(residual)) return Unsolved{&equation, 0, 0, true};
    const auto part = crossing(residual, equation.last);
    if (!part && round == 0) {
      Unsolved unsolved{&equation, std::numeric_limits<double>::infinity(),
                        -std::numeric_limits<double>::infinity(), false};
      for (const Residual& r : residual) {
        if (std::isnan(r.left)) continue;
        unsolved.least = std::min(unsolved.least, r.left + equation.target);
        unsolved.greatest = std::max(unsolved.greatest, r.left + equation.target);
      }
      return unsolved;
    }
    // Rounding may hide the change of sign in a bracket of a few numbers: its middle is the root.
    if (!part) {
      equation.value = 0.5 * (low + high);
      return std::nullopt;
    }
    const double below = residual[*part].left;
    const double above = residual[*part + 1].left;
    const bool nearer_low = std::abs(below) <= std::abs(above);
    equation.value = nearer_low ? values[*part] : values[*part + 1];
    low = values[*part];
    high = values[*part + 1];
    if (below == 0 || above == 0) return std::nullopt;
    if (std::nextafter(low, high) >= high || round == 12) return std::nullopt;
  }
}

}  // namespace

std::vector<Unsolved> solve(std::vector<Equation>& equations, solver::SweepSetup& setup) {
  std::vector<Unsolved> unsolved;
  const int rounds = equations.size() == 1 ? 1 : 20;
  for (int round = 0; round < rounds; ++round) {
    bool changed = false;
    for (Equation& equation : equations) {
      const double before = equation.value;
      if (const auto without = solve_one(equation, setup)) {
        unsolved.push_back(*without);
        continue;
      }
      changed =
          changed || round == 0 ||
          std::abs(equation.value - before) > 1e-14 * (equation.between[1] - equation.between[0]);
      set_nominal(setup, equation.input, equation.value);
    }
    if (!changed || !unsolved.empty()) break;
  }
  return unsolved;
}

std::vector<Unsolved> solve_each_point(std::vector<Equation>& equations,
                                       solver::SweepSetup& setup) {
  const solver::Sweep sweep(setup);
  for (std::uint64_t point = 0; point < sweep.points(); ++point) {
    solver::SweepSetup at_point = sweep.at_point(point);
    std::vector<Unsolved> unsolved = solve(equations, at_point);
    for (Unsolved& each : unsolved) each.point = point;
    if (!unsolved.empty()) return unsolved;
    for (Equation& equation : equations) equation.by_point.push_back(equation.value);
  }
  const solver::SweepSetup means = nominal(setup);
  for (const Equation& equation : equations) {
    std::vector<double>& shifts = setup.inputs[equation.input].shifts;
    for (const double value : equation.by_point) {
      shifts.push_back(value - means.inputs[equation.input].a);
    }
  }
  return {};
}

std::optional<std::vector<std::vector<double>>> cholesky(
    const std::vector<std::vector<double>>& matrix) {
  const auto n = static_cast<Eigen::Index>(matrix.size());
  Eigen::MatrixXd full(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      full(a, b) = matrix[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> decomposition(full);
  if (decomposition.info() != Eigen::Success) return std::nullopt;
  const Eigen::MatrixXd lower = decomposition.matrixL();
  std::vector<std::vector<double>> factor(matrix.size(), std::vector<double>(matrix.size(), 0));
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b <= a; ++b) {
      factor[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)] = lower(a, b);
    }
  }
  return factor;
}

}  // namespace salvo::scene
