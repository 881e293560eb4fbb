// Datasets back into columns.
#pragma once

#include <string>

#include "recording/frame.hpp"
#include "recording/hdf5.hpp"

namespace salvo::recording {

/// The column of a dataset in `group`; `rows` becomes its number of rows. Throws hdf5::Error.
FrameColumn read_column(hid_t group, const std::string& name, soa::Precision precision,
                        std::size_t& rows);

}  // namespace salvo::recording
