// A table of numbers in a CSV file: one header line of names, each with or without a unit in
// brackets ("speed [fps]"), then a line a row.
#pragma once

#include <string>
#include <vector>

#include "scene/input_table.hpp"

namespace salvo::scene {

class CsvTable : public InputTable {
 public:
  /// Reads a file. Throws TableError.
  explicit CsvTable(std::string path);

  std::size_t rows() const { return cells_.size(); }
  const std::vector<std::string>& names() const { return names_; }
  std::vector<double> column(const std::string& name, const std::string& unit) override;

 private:
  std::string path_;
  std::vector<std::string> names_;
  std::vector<std::string> units_;
  std::vector<std::vector<std::string>> cells_;
  std::vector<std::size_t> lines_;
};

}  // namespace salvo::scene
