// A table of numbers in a CSV file: one header line of names, each with or without a unit in
// brackets ("speed [fps]"), then a line a row.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace salvo::scene {

/// what() says which line and column of the file is wrong, and how; hint() what to do.
class TableError : public std::runtime_error {
 public:
  TableError(const std::string& problem, std::string hint)
      : std::runtime_error(problem), hint_(std::move(hint)) {}
  const std::string& hint() const { return hint_; }

 private:
  std::string hint_;
};

class CsvTable {
 public:
  /// Reads a file. Throws TableError.
  explicit CsvTable(std::string path);

  std::size_t rows() const { return cells_.size(); }
  const std::vector<std::string>& names() const { return names_; }
  /// A column's numbers as multiples of `unit`: of the header's unit, else of `unit` itself. Throws
  /// TableError.
  std::vector<double> column(const std::string& name, const std::string& unit) const;

 private:
  std::string path_;
  std::vector<std::string> names_;
  std::vector<std::string> units_;
  std::vector<std::vector<std::string>> cells_;
  std::vector<std::size_t> lines_;
};

}  // namespace salvo::scene
