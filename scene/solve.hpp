// Inputs that are solved for before a sweep runs: zeroing, aiming and other inverse problems. The
// bracket is divided into equal parts, all of which are run as one batch, and so is the first part
// over which the quantity passes its target, until no number is left between its ends. With several
// equations each is solved in turn, until none changes its input.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "solver/sweep.hpp"

namespace salvo::scene {

struct Equation {
  std::string path;  ///< in the scene
  std::size_t input = 0;
  std::array<double, 2> between{};
  std::size_t column = 0;  ///< of Sweep::fields()
  double target = 0;
  bool last = false;                     ///< of several roots
  std::optional<std::uint32_t> outcome;  ///< trajectories that end otherwise do not count
  std::vector<std::pair<std::size_t, double>> with;
  double value = 0;  ///< the root
  std::vector<double> by_point;
};

struct Unsolved {
  const Equation* equation;
  double least;  ///< that the quantity comes to
  double greatest;
  bool pinned;  ///< it is at its target for many values
  std::uint64_t point = 0;
};

/// Solves the equations with all inputs at their nominal values and puts the roots into the setup,
/// as constants or means. Returns those without a root.
std::vector<Unsolved> solve(std::vector<Equation>& equations, solver::SweepSetup& setup);

/// The same at each point of the grid; the inputs get shifts that bring them to the roots.
std::vector<Unsolved> solve_each_point(std::vector<Equation>& equations, solver::SweepSetup& setup);

/// The lower triangular factor of a positive definite matrix; nothing when it is not.
std::optional<std::vector<std::vector<double>>> cholesky(
    const std::vector<std::vector<double>>& matrix);

}  // namespace salvo::scene
