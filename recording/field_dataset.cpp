#include "recording/field_dataset.hpp"

#include <array>
#include <cstring>

namespace salvo::recording {

hid_t type_of(soa::Scalar scalar, soa::Precision precision) {
  switch (scalar) {
    case soa::Scalar::real:
      return precision == soa::Precision::float32 ? hdf5::type_of<float>()
                                                  : hdf5::type_of<double>();
    case soa::Scalar::int32:
      return hdf5::type_of<std::int32_t>();
    case soa::Scalar::uint32:
      return hdf5::type_of<std::uint32_t>();
    case soa::Scalar::uint64:
      return hdf5::type_of<std::uint64_t>();
  }
  return H5I_INVALID_HID;
}

void describe(hid_t dataset, const soa::Field& field) {
  hdf5::write_attribute(dataset, "units", field.unit);
  hdf5::write_attribute(dataset, "meaning", field.meaning);
}

hdf5::Handle create_field_dataset(hid_t group, const std::string& name, const soa::Field& field,
                                  soa::Precision precision, const hdf5::Extents& extents,
                                  std::optional<double> uniform) {
  const hid_t type = type_of(field.scalar, precision);
  hdf5::Handle dataset;
  if (!uniform) {
    dataset = hdf5::create_dataset(group, name, type, extents);
  } else {
    // HDF5 converts from double; the values of integer fields are exact in it.
    std::array<std::byte, 8> constant{};
    std::memcpy(constant.data(), &*uniform, sizeof *uniform);
    hdf5::checked(
        H5Tconvert(hdf5::type_of<double>(), type, 1, constant.data(), nullptr, H5P_DEFAULT),
        "convert a uniform value");
    dataset = hdf5::create_constant_dataset(group, name, type, extents, constant.data());
  }
  describe(dataset, field);
  return dataset;
}

}  // namespace salvo::recording
