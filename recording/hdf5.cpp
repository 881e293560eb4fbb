#include "recording/hdf5.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>

namespace salvo::recording::hdf5 {

namespace {

static_assert(std::endian::native == std::endian::little, "files are little-endian, like memory");

std::recursive_mutex library;

// The innermost message of the error stack is the one that says what happened.
std::string last_words() {
  std::string words = "unknown error";
  const auto keep = [](unsigned, const H5E_error2_t* entry, void* data) -> herr_t {
    if (entry->desc) *static_cast<std::string*>(data) = entry->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, keep, &words);
  H5Eclear2(H5E_DEFAULT);
  return words;
}

Handle dataspace(const Extents& extents) {
  if (extents.empty()) return {H5Screate(H5S_SCALAR), "create a dataspace"};
  return {H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr),
          "create a dataspace"};
}

// ParaView wants its texts to be called ASCII.
H5T_cset_t character_set(std::string_view text) {
  const bool ascii = std::all_of(text.begin(), text.end(), [](char c) { return (c & 0x80) == 0; });
  return ascii ? H5T_CSET_ASCII : H5T_CSET_UTF8;
}

Handle text_type(std::size_t length, H5T_cset_t set) {
  Handle type(H5Tcopy(H5T_C_S1), "create a string type");
  checked(H5Tset_size(type, std::max<std::size_t>(length, 1)), "create a string type");
  checked(H5Tset_strpad(type, H5T_STR_NULLPAD), "create a string type");
  checked(H5Tset_cset(type, set), "create a string type");
  return type;
}

// No time stamps: equal runs give equal bytes.
Handle dataset_properties() {
  Handle properties(H5Pcreate(H5P_DATASET_CREATE), "create dataset properties");
  checked(H5Pset_obj_track_times(properties, false), "switch off time stamps");
  return properties;
}

Handle create(hid_t parent, const std::string& name, hid_t type, const Extents& extents,
              hid_t properties) {
  const Handle space = dataspace(extents);
  return {H5Dcreate2(parent, name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT),
          "create dataset " + name};
}

// A value that no row holds: NaN, or the greatest of the whole numbers.
void fill_with_nothing(hid_t properties, hid_t type) {
  std::array<std::byte, 8> value{};
  const std::size_t size = H5Tget_size(type);
  if (H5Tget_class(type) == H5T_FLOAT) {
    const double wide = std::numeric_limits<double>::quiet_NaN();
    const float narrow = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(value.data(), size == sizeof wide ? static_cast<const void*>(&wide) : &narrow,
                size);
  } else {
    value.fill(std::byte{0xff});
    if (H5Tget_sign(type) == H5T_SGN_2) value[size - 1] = std::byte{0x7f};
  }
  checked(H5Pset_fill_value(properties, type, value.data()), "set a fill value");
}

}  // namespace

Session::Session() : lock_(library) {
  H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Session::~Session() { H5Eset_auto2(H5E_DEFAULT, print_, print_data_); }

std::string library_version() {
  const Session session;
  unsigned major = 0;
  unsigned minor = 0;
  unsigned release = 0;
  H5get_libversion(&major, &minor, &release);
  return fmt::format("{}.{}.{}", major, minor, release);
}

template <std::signed_integral Result>
Result checked(Result result, std::string_view action) {
  if (result < 0) throw Error(fmt::format("HDF5 cannot {}: {}", action, last_words()));
  return result;
}
template herr_t checked(herr_t, std::string_view);
template hid_t checked(hid_t, std::string_view);
template hssize_t checked(hssize_t, std::string_view);

Handle::~Handle() {
  if (id_ < 0) return;
  const Session session;
  H5Idec_ref(id_);
}

template <>
hid_t type_of<float>() {
  return H5T_IEEE_F32LE;
}
template <>
hid_t type_of<double>() {
  return H5T_IEEE_F64LE;
}
template <>
hid_t type_of<std::uint8_t>() {
  return H5T_STD_U8LE;
}
template <>
hid_t type_of<std::int32_t>() {
  return H5T_STD_I32LE;
}
template <>
hid_t type_of<std::uint32_t>() {
  return H5T_STD_U32LE;
}
template <>
hid_t type_of<std::int64_t>() {
  return H5T_STD_I64LE;
}
template <>
hid_t type_of<std::uint64_t>() {
  return H5T_STD_U64LE;
}

MemoryFile::MemoryFile() {
  const Session session;
  constexpr std::size_t growth = std::size_t{4} << 20;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), "create file properties");
  checked(H5Pset_fapl_core(access, growth, false), "keep a file in memory");
  // Readable by HDF5 1.8 and later; the formats of these versions need no global state to be equal
  // in equal runs.
  checked(H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V110), "set the file version");
  // Files in memory need different names, which are not part of their bytes.
  static std::uint64_t created = 0;
  const std::string name = fmt::format("in memory {}", created++);
  const Handle root(H5Pcreate(H5P_FILE_CREATE), "create file properties");
  checked(H5Pset_obj_track_times(root, false), "switch off time stamps");
  file_ = Handle(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, root, access), "create a file");
}

std::span<std::byte> MemoryFile::bytes() {
  const Session session;
  checked(H5Fflush(file_, H5F_SCOPE_LOCAL), "finish a file");
  const auto size = checked<hssize_t>(H5Fget_file_image(file_, nullptr, 0), "measure a file");
  void* memory = nullptr;
  checked(H5Fget_vfd_handle(file_, H5P_DEFAULT, &memory), "reach a file's bytes");
  return {*static_cast<std::byte* const*>(memory), static_cast<std::size_t>(size)};
}

Handle open_file(const std::filesystem::path& path) {
  return {H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), "open the file"};
}

Handle create_group(hid_t parent, const std::string& name) {
  const Handle properties(H5Pcreate(H5P_GROUP_CREATE), "create group properties");
  checked(H5Pset_obj_track_times(properties, false), "switch off time stamps");
  // Keeps the attributes in the group's header; the default moves more than eight into a heap.
  constexpr unsigned many = 64;
  checked(H5Pset_attr_phase_change(properties, many, many / 2), "set group properties");
  return {H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, properties, H5P_DEFAULT),
          "create group " + name};
}

Handle open_group(hid_t parent, const std::string& name) {
  return {H5Gopen2(parent, name.c_str(), H5P_DEFAULT), "open group " + name};
}

void create_soft_link(hid_t parent, const std::string& name, const std::string& target) {
  checked(H5Lcreate_soft(target.c_str(), parent, name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
          "create link " + name);
}

Handle create_dataset(hid_t parent, const std::string& name, hid_t type, const Extents& extents) {
  const Handle properties = dataset_properties();
  checked(H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER), "set dataset properties");
  checked(H5Pset_alloc_time(properties, H5D_ALLOC_TIME_EARLY), "set dataset properties");
  return create(parent, name, type, extents, properties);
}

Handle create_constant_dataset(hid_t parent, const std::string& name, hid_t type,
                               const Extents& extents, const void* value) {
  const Handle properties = dataset_properties();
  checked(H5Pset_alloc_time(properties, H5D_ALLOC_TIME_LATE), "set dataset properties");
  checked(H5Pset_fill_value(properties, type, value), "set a fill value");
  return create(parent, name, type, extents, properties);
}

Handle create_deflated_dataset(hid_t parent, const std::string& name, hid_t type, hsize_t count,
                               hsize_t block) {
  const Handle properties = dataset_properties();
  constexpr unsigned fastest = 1;
  checked(H5Pset_chunk(properties, 1, &block), "set dataset properties");
  checked(H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER), "set dataset properties");
  checked(H5Pset_shuffle(properties), "set dataset properties");
  checked(H5Pset_deflate(properties, fastest), "set dataset properties");
  return create(parent, name, type, {count}, properties);
}

void write_deflated_block(hid_t dataset, hsize_t first, std::span<const std::byte> deflated) {
  constexpr std::uint32_t all_filters = 0;
  checked(
      H5Dwrite_chunk(dataset, H5P_DEFAULT, all_filters, &first, deflated.size(), deflated.data()),
      "write a block");
}

void write_all(hid_t dataset, hid_t type, const void* values) {
  checked(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), "write a dataset");
}

std::optional<std::size_t> offset_of(hid_t dataset) {
  const haddr_t offset = H5Dget_offset(dataset);
  H5Eclear2(H5E_DEFAULT);
  return offset == HADDR_UNDEF ? std::nullopt : std::optional<std::size_t>(offset);
}

Handle create_virtual_dataset(hid_t parent, const std::string& name, hid_t type,
                              const Extents& extents, const std::string& path,
                              std::span<const VirtualPart> parts) {
  const Handle properties = dataset_properties();
  fill_with_nothing(properties, type);
  const Handle space = dataspace(extents);
  Extents start(extents.size(), 0);
  for (const VirtualPart& part : parts) {
    Extents block = extents;
    block[0] = part.rows;
    checked(
        H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, block.data(), nullptr),
        "select rows");
    const Handle source = dataspace(block);
    checked(H5Pset_virtual(properties, space, part.file.c_str(), path.c_str(), source),
            "map a dataset");
    start[0] += part.rows;
  }
  return create(parent, name, type, extents, properties);
}

Handle open_dataset(hid_t parent, const std::string& name) {
  return {H5Dopen2(parent, name.c_str(), H5P_DEFAULT), "open dataset " + name};
}

Extents extents_of(hid_t dataset) {
  const Handle space(H5Dget_space(dataset), "read a dataspace");
  Extents extents(static_cast<std::size_t>(
      checked(H5Sget_simple_extent_ndims(space), "read a dataset's extents")));
  checked(H5Sget_simple_extent_dims(space, extents.data(), nullptr), "read a dataset's extents");
  return extents;
}

Handle type_of_dataset(hid_t dataset) { return {H5Dget_type(dataset), "read a dataset's type"}; }

void read_all(hid_t dataset, hid_t type, void* values) {
  checked(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), "read a dataset");
}

std::vector<std::string> names_in(hid_t group) {
  std::vector<std::string> names;
  const auto add = [](hid_t, const char* name, const H5L_info_t*, void* data) -> herr_t {
    static_cast<std::vector<std::string>*>(data)->emplace_back(name);
    return 0;
  };
  checked(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names), "list a group");
  return names;
}

std::vector<std::string> attribute_names(hid_t object) {
  std::vector<std::string> names;
  const auto add = [](hid_t, const char* name, const H5A_info_t*, void* data) -> herr_t {
    static_cast<std::vector<std::string>*>(data)->emplace_back(name);
    return 0;
  };
  checked(H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names),
          "list the attributes");
  return names;
}

void write_attribute(hid_t object, const std::string& name, hid_t type, const Extents& extents,
                     const void* values) {
  const Handle space = dataspace(extents);
  const Handle attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT),
                         "create attribute " + name);
  checked(H5Awrite(attribute, type, values), "write attribute " + name);
}

void write_attribute(hid_t object, const std::string& name, std::string_view text) {
  const std::string terminated(text);  // readable even when empty
  write_attribute(object, name, text_type(text.size(), character_set(text)), {},
                  terminated.c_str());
}

void write_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts) {
  std::size_t length = 1;
  for (const std::string& text : texts) length = std::max(length, text.size());
  std::string packed;
  for (const std::string& text : texts) packed += text + std::string(length - text.size(), '\0');
  const Handle type = text_type(length, character_set(packed));
  if (texts.empty()) {
    const Handle none(H5Screate(H5S_NULL), "create a dataspace");
    const Handle attribute(H5Acreate2(object, name.c_str(), type, none, H5P_DEFAULT, H5P_DEFAULT),
                           "create attribute " + name);
  } else {
    write_attribute(object, name, type, {texts.size()}, packed.data());
  }
}

namespace {

Handle open_attribute(hid_t object, const std::string& name) {
  return {H5Aopen(object, name.c_str(), H5P_DEFAULT), "open attribute " + name};
}

std::size_t count_of(hid_t attribute) {
  const Handle space(H5Aget_space(attribute), "read an attribute");
  return static_cast<std::size_t>(
      checked<hssize_t>(H5Sget_simple_extent_npoints(space), "read an attribute"));
}

}  // namespace

void read_attribute(hid_t object, const std::string& name, hid_t type, std::size_t count,
                    void* values) {
  const Handle attribute = open_attribute(object, name);
  if (count_of(attribute) != count) {
    throw Error(fmt::format("attribute {} does not hold {} values", name, count));
  }
  checked(H5Aread(attribute, type, values), "read attribute " + name);
}

std::string read_text_attribute(hid_t object, const std::string& name) {
  const std::vector<std::string> texts = read_texts_attribute(object, name);
  if (texts.size() != 1) throw Error(fmt::format("attribute {} is not one text", name));
  return texts.front();
}

std::vector<std::string> read_texts_attribute(hid_t object, const std::string& name) {
  const Handle attribute = open_attribute(object, name);
  const Handle type(H5Aget_type(attribute), "read attribute " + name);
  if (H5Tget_class(type) != H5T_STRING) {
    throw Error(fmt::format("attribute {} is not a text", name));
  }
  const std::size_t length = H5Tget_size(type);
  const std::size_t count = count_of(attribute);
  std::vector<std::string> texts;
  if (count == 0) return texts;
  if (H5Tis_variable_str(type) > 0) {
    std::vector<char*> read(count);
    checked(H5Aread(attribute, type, read.data()), "read attribute " + name);
    for (char* text : read) {
      texts.emplace_back(text != nullptr ? text : "");
      H5free_memory(text);
    }
    return texts;
  }
  std::string packed(count * length, '\0');
  checked(H5Aread(attribute, type, packed.data()), "read attribute " + name);
  for (std::size_t i = 0; i < count; ++i) {
    std::string text = packed.substr(i * length, length);
    text.erase(text.find_last_not_of('\0') + 1);
    texts.push_back(std::move(text));
  }
  return texts;
}

}  // namespace salvo::recording::hdf5
