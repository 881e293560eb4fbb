#include "recording/column_reader.hpp"

#include <fmt/format.h>

namespace salvo::recording {

namespace {

using hdf5::Handle;

soa::Scalar scalar_of(hid_t type, soa::Precision precision, const std::string& name) {
  const hid_t real =
      precision == soa::Precision::float32 ? hdf5::type_of<float>() : hdf5::type_of<double>();
  if (H5Tequal(type, real) > 0) return soa::Scalar::real;
  if (H5Tequal(type, hdf5::type_of<std::int32_t>()) > 0) return soa::Scalar::int32;
  if (H5Tequal(type, hdf5::type_of<std::uint32_t>()) > 0) return soa::Scalar::uint32;
  if (H5Tequal(type, hdf5::type_of<std::uint64_t>()) > 0) return soa::Scalar::uint64;
  throw hdf5::Error(fmt::format("dataset {} has an unknown type", name));
}

}  // namespace

FrameColumn read_column(hid_t group, const std::string& name, soa::Precision precision,
                        std::size_t& rows) {
  const Handle dataset = hdf5::open_dataset(group, name);
  const Handle type = hdf5::type_of_dataset(dataset);
  const hdf5::Extents extents = hdf5::extents_of(dataset);
  if (extents.empty() || extents.size() > 2) {
    throw hdf5::Error(fmt::format("dataset {} is not a table of rows", name));
  }
  FrameColumn column;
  column.name = name;
  column.unit = hdf5::read_text_attribute(dataset, "units");
  column.meaning = hdf5::read_text_attribute(dataset, "meaning");
  column.scalar = scalar_of(type, precision, name);
  column.components = extents.size() == 2 ? extents[1] : 1;
  rows = extents[0];
  column.values.resize(rows * column.components * size_of(column.scalar, precision));
  hdf5::read_all(dataset, type, column.values.data());
  return column;
}

}  // namespace salvo::recording
