#include "cli/drop_table.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "cli/text_table.hpp"

namespace salvo::cli {

namespace {

// Without the sign of what rounds to zero.
std::string rounded(double value, int digits) {
  std::string text = fmt::format("{:.{}f}", value, digits);
  if (text.starts_with('-') && text.find_first_of("123456789") == std::string::npos) {
    text.erase(0, 1);
  }
  return text;
}

}  // namespace

std::vector<DropLine> drop_lines(const solver::Sweep& sweep, const solver::SweepRows& rows,
                                 std::size_t row, double click) {
  const auto value = [&](std::string_view name, std::size_t at) {
    for (std::size_t f = 0; f < sweep.sample_fields().size(); ++f) {
      if (sweep.sample_fields()[f].name == name) return rows.samples[f][at];
    }
    return std::numeric_limits<double>::quiet_NaN();
  };
  std::vector<DropLine> lines;
  for (std::size_t level = 0; level < sweep.levels(); ++level) {
    const std::size_t at = row * sweep.levels() + level;
    const double x = value("x", at);
    const double y = value("y", at);
    const double z = value("z", at);
    lines.push_back({x, 0 - y, z, rows.sample_time[at], value("speed", at), value("energy", at),
                     (0 - std::atan2(y, x)) / click, (0 - std::atan2(z, x)) / click});
  }
  return lines;
}

std::string drop_table_text(const std::vector<DropLine>& lines) {
  TextTable table({"range m", "drop m", "windage m", "time s", "speed m/s", "energy J", "clicks up",
                   "clicks right"});
  for (const DropLine& line : lines) {
    table.add({fmt::format("{:g}", line.range), rounded(line.drop, 3), rounded(line.windage, 3),
               rounded(line.time, 3), rounded(line.speed, 1), rounded(line.energy, 0),
               rounded(line.clicks_up, 1), rounded(line.clicks_right, 1)});
  }
  return table.text();
}

}  // namespace salvo::cli
