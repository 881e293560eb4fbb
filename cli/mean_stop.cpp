#include "cli/mean_stop.hpp"

#include "soa/value_at.hpp"
#include "solver/floating_point_environment.hpp"

namespace salvo::cli {

void MeanStop::add_part(std::span<const std::vector<double>> columns) {
  // Where the sweep ends must not depend on how the caller's thread rounds.
  const solver::FloatingPointEnvironment environment;
  moments_.add_part(columns);
  if (moments_.count() < 2) return;
  half_width_ = solver::half_width_of_mean(moments_, 0, scene_.stop->confidence);
  reached_ = half_width_ <= scene_.stop->half_width;
}

void MeanStop::add_part(const solver::Sweep& sweep, const solver::SweepRows& rows) {
  std::size_t outcome = 0;
  while (sweep.fields()[outcome].name != "outcome") ++outcome;
  std::vector<double> counted;
  for (std::size_t row = 0; row < rows.table.rows(); ++row) {
    if (scene_.counted[static_cast<std::size_t>(soa::value_at(rows.table, outcome, row))]) {
      counted.push_back(soa::value_at(rows.table, scene_.stop->column, row));
    }
  }
  add_part(std::span(&counted, 1));
}

}  // namespace salvo::cli
