#include "recording/dimension_scales.hpp"

#include <cstddef>
#include <map>
#include <string_view>

namespace salvo::recording {

namespace {

using hdf5::checked;
using hdf5::Handle;

// The attributes are those of HDF5's own H5DSattach_scale. That function is in another library,
// and writes a scale's list of datasets anew for every dataset that is attached.

// What a scale says of one dimension that it is the scale of. Without padding, whose bytes would
// be those that memory happened to have.
struct Reference {
  hobj_ref_t dataset;
  std::int32_t dimension;
  std::int32_t nothing = 0;
};
static_assert(sizeof(Reference) == 16);

hobj_ref_t reference_to(hid_t file, const std::string& path) {
  hobj_ref_t reference{};
  checked(H5Rcreate(&reference, file, path.c_str(), H5R_OBJECT, H5I_INVALID_HID),
          "refer to " + path);
  return reference;
}

// The library takes such texts only when they end in a zero.
void write_terminated(hid_t object, const std::string& name, std::string_view text) {
  const std::string terminated(text);
  const Handle type(H5Tcopy(H5T_C_S1), "create a string type");
  checked(H5Tset_size(type, terminated.size() + 1), "create a string type");
  hdf5::write_attribute(object, name, type, {}, terminated.c_str());
}

void write_list_of_scales(hid_t dataset, std::vector<hobj_ref_t> scales) {
  std::vector<hvl_t> lists;
  lists.reserve(scales.size());
  for (hobj_ref_t& scale : scales) lists.push_back({1, &scale});
  const Handle type(H5Tvlen_create(H5T_STD_REF_OBJ), "create a list type");
  hdf5::write_attribute(dataset, "DIMENSION_LIST", type, {lists.size()}, lists.data());
}

void write_list_of_datasets(hid_t scale, const std::vector<Reference>& references) {
  const Handle type(H5Tcreate(H5T_COMPOUND, sizeof(Reference)), "create a reference type");
  checked(H5Tinsert(type, "dataset", offsetof(Reference, dataset), H5T_STD_REF_OBJ),
          "create a reference type");
  checked(
      H5Tinsert(type, "dimension", offsetof(Reference, dimension), hdf5::type_of<std::int32_t>()),
      "create a reference type");
  hdf5::write_attribute(scale, "REFERENCE_LIST", type, {references.size()}, references.data());
}

}  // namespace

void write_dimension_scales(hid_t file, std::span<const Dimensions> datasets) {
  std::map<std::string, std::vector<Reference>> scales;
  for (const Dimensions& dimensions : datasets) {
    const hobj_ref_t dataset = reference_to(file, dimensions.dataset);
    std::vector<hobj_ref_t> list;
    for (const std::string& scale : dimensions.scales) {
      scales[scale].push_back({dataset, static_cast<std::int32_t>(list.size())});
      list.push_back(reference_to(file, scale));
    }
    write_list_of_scales(hdf5::open_dataset(file, dimensions.dataset), std::move(list));
  }
  for (const auto& [path, references] : scales) {
    const Handle scale = hdf5::open_dataset(file, path);
    write_terminated(scale, "CLASS", "DIMENSION_SCALE");
    // netCDF-4 takes the name of the dimension from the path.
    write_terminated(scale, "NAME", path.substr(path.rfind('/') + 1));
    write_list_of_datasets(scale, references);
  }
}

}  // namespace salvo::recording
