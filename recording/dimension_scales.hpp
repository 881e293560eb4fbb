// Dimension scales: datasets that hold the coordinates along the dimensions of others. By them
// readers of netCDF-4 files, xarray for one, know which datasets belong together.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "recording/hdf5.hpp"

namespace salvo::recording {

/// A dataset, and of each of its dimensions the scale; both named by path.
struct Dimensions {
  std::string dataset;
  std::vector<std::string> scales;
};

/// Writes the attributes that make the scales scales, and connect them with the datasets. Once for
/// a file, after all datasets are there. A scale is no dataset that has scales. Throws hdf5::Error.
void write_dimension_scales(hid_t file, std::span<const Dimensions> datasets);

}  // namespace salvo::recording
