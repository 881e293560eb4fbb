// Inputs of a sweep from an HDF5 file: a column is a one-dimensional dataset of numbers, named by
// its path, with its unit in the attribute `units`. The rows of one sweep can so be the inputs of
// another.
#pragma once

#include <memory>
#include <string>

#include "scene/input_table.hpp"

namespace salvo::recording {

/// For scene::open_hdf5_tables_with. Throws scene::TableError. A recording of salvo's must be
/// intact, with all the files that it shows.
std::unique_ptr<scene::InputTable> open_hdf5_table(const std::string& path);

}  // namespace salvo::recording
