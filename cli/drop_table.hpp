// Samples at ranges as a shooter reads them: drop, windage, and by how many clicks to turn the
// sight.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "solver/sweep.hpp"

namespace salvo::cli {

struct DropLine {
  double range;      ///< m
  double drop;       ///< m below the line of sight, y = 0
  double windage;    ///< m to the right
  double time;       ///< s
  double speed;      ///< m/s
  double energy;     ///< J; NaN where the model has none
  double clicks_up;  ///< that bring the bullet to the line of sight
  double clicks_right;
};

/// The samples of a row; `click` is the angle of a click of the sight, in rad.
std::vector<DropLine> drop_lines(const solver::Sweep& sweep, const solver::SweepRows& rows,
                                 std::size_t row, double click);

std::string drop_table_text(const std::vector<DropLine>& lines);

}  // namespace salvo::cli
