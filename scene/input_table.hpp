// What the inputs of a sweep may be columns of, whatever kind of file they lie in. CSV files are
// read here. HDF5 files are read by what the program provides: scene/ builds without that library.
#pragma once

#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace salvo::scene {

/// what() says which place of the file is wrong, and how; hint() what to do.
class TableError : public std::runtime_error {
 public:
  TableError(const std::string& problem, std::string hint)
      : std::runtime_error(problem), hint_(std::move(hint)) {}
  const std::string& hint() const { return hint_; }

 private:
  std::string hint_;
};

class InputTable {
 public:
  virtual ~InputTable() = default;
  /// A column's numbers as multiples of `unit`, all finite: of the unit that the file gives, else
  /// of `unit` itself. Throws TableError, also for a column whose length is not that of the columns
  /// before it.
  virtual std::vector<double> column(const std::string& name, const std::string& unit) = 0;
};

/// Opens a file as a table. Throws TableError.
using TableOpener = std::unique_ptr<InputTable> (*)(const std::string& path);

/// From now on HDF5 files are opened so. Once, before scenes are read and threads are started.
void open_hdf5_tables_with(TableOpener opener);

/// Names that end in .hdf, .h5 or .hdf5 are HDF5 files, all others CSV. Throws TableError.
std::unique_ptr<InputTable> open_table(const std::string& path);

/// Without the byte order mark that some editors begin a file with and that is no part of its first
/// line.
std::string_view without_mark(std::string_view text);

/// The table has no such column; `what` its columns are called. The hint is the nearest of `names`,
/// else all of them.
TableError no_such_column(const std::string& path, const std::string& what, const std::string& name,
                          std::span<const std::string> names);

}  // namespace salvo::scene
