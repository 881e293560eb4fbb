#include "scene/csv_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <system_error>

#include "scene/units.hpp"

namespace salvo::scene {

namespace {

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\"");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\"") - first + 1);
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::size_t from = 0;
  while (true) {
    const std::size_t comma = line.find(',', from);
    cells.push_back(trimmed(line.substr(from, comma - from)));
    if (comma == std::string::npos) return cells;
    from = comma + 1;
  }
}

}  // namespace

CsvTable::CsvTable(std::string path) : path_(std::move(path)) {
  errno = 0;
  std::ifstream file(path_);
  if (!file) {
    throw TableError(fmt::format("cannot read {}: {}", path_,
                                 std::generic_category().message(errno != 0 ? errno : ENOENT)),
                     "its path is relative to the scene's");
  }
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (number == 1) line = std::string(without_mark(line));
    if (trimmed(line).empty() || line[0] == '#') continue;
    std::vector<std::string> cells = split(line);
    if (names_.empty()) {
      for (const std::string& cell : cells) {
        const std::size_t bracket = cell.find('[');
        const std::size_t end = cell.find(']');
        if ((bracket == std::string::npos) != (end == std::string::npos)) {
          throw TableError(fmt::format("{}:{}: \"{}\" has one bracket", path_, number, cell),
                           "expected NAME or NAME [UNIT]");
        }
        const std::string name = trimmed(cell.substr(0, bracket));
        if (std::ranges::find(names_, name) != names_.end()) {
          throw TableError(fmt::format("{}:{}: two columns are \"{}\"", path_, number, name),
                           "expected names that differ");
        }
        names_.push_back(name);
        units_.push_back(bracket == std::string::npos
                             ? ""
                             : trimmed(cell.substr(bracket + 1, end - bracket - 1)));
      }
      continue;
    }
    if (cells.size() != names_.size()) {
      throw TableError(fmt::format("{}:{}: {} cells", path_, number, cells.size()),
                       fmt::format("expected {}, as in the header", names_.size()));
    }
    cells_.push_back(std::move(cells));
    lines_.push_back(number);
  }
  if (cells_.empty()) throw TableError(path_ + " has no rows", "expected a header and numbers");
}

std::vector<double> CsvTable::column(const std::string& name, const std::string& unit) {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end()) throw no_such_column(path_, "column", name, names_);
  const auto index = static_cast<std::size_t>(found - names_.begin());
  std::vector<double> values;
  for (std::size_t row = 0; row < cells_.size(); ++row) {
    const std::string& cell = cells_[row][index];
    if (cell.empty()) {
      throw TableError(fmt::format("{}:{}: column \"{}\" is empty", path_, lines_[row], name),
                       "expected a number");
    }
    try {
      const bool plain = cell.find_first_not_of("0123456789+-.eE") == std::string::npos;
      if (!units_[index].empty()) {
        values.push_back(quantity(cell + " " + units_[index], unit));
      } else {
        values.push_back(plain ? number_in(cell, unit) : quantity(cell, unit));
      }
    } catch (const UnitError& error) {
      throw TableError(
          fmt::format("{}:{}: column \"{}\": {}", path_, lines_[row], name, error.what()),
          error.hint());
    }
  }
  return values;
}

}  // namespace salvo::scene
