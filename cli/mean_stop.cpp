#include "cli/mean_stop.hpp"

#include "solver/floating_point_environment.hpp"

namespace salvo::cli {

namespace {

double number_at(const soa::Table& table, std::size_t field, std::size_t row) {
  if (!table.stored(field)) return table.uniform(field);
  switch (table.fields()[field].scalar) {
    case soa::Scalar::uint64:
      return static_cast<double>(table.column<std::uint64_t>(field)[row]);
    case soa::Scalar::uint32:
      return static_cast<double>(table.column<std::uint32_t>(field)[row]);
    case soa::Scalar::int32:
      return static_cast<double>(table.column<std::int32_t>(field)[row]);
    case soa::Scalar::real:
      break;
  }
  return table.precision() == soa::Precision::float32
             ? static_cast<double>(table.column<float>(field)[row])
             : table.column<double>(field)[row];
}

}  // namespace

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
    if (scene_.counted[static_cast<std::size_t>(number_at(rows.table, outcome, row))]) {
      counted.push_back(number_at(rows.table, scene_.stop->column, row));
    }
  }
  add_part(std::span(&counted, 1));
}

}  // namespace salvo::cli
