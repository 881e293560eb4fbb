// The dataset of a field: its type, unit and meaning.
#pragma once

#include <optional>
#include <string>

#include "recording/hdf5.hpp"
#include "soa/field.hpp"

namespace salvo::recording {

hid_t type_of(soa::Scalar scalar, soa::Precision precision);

/// A dataset to be filled in, or one that reads as `uniform` everywhere.
hdf5::Handle create_field_dataset(hid_t group, const std::string& name, const soa::Field& field,
                                  soa::Precision precision, const hdf5::Extents& extents,
                                  std::optional<double> uniform);

void describe(hid_t dataset, const soa::Field& field);

}  // namespace salvo::recording
