// The HDF5 C API with owners and exceptions: no identifier leaks, no error is printed, every
// failure says what HDF5 said. Files are composed in memory and written by us, so that HDF5 never
// meets a full disk.
#pragma once

#include <hdf5.h>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace salvo::recording::hdf5 {

class Error : public std::runtime_error {
  using runtime_error::runtime_error;
};

/// Lets one thread at a time into the library, whether or not it was built for threads, and keeps
/// it from printing.
class Session {
 public:
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

 private:
  std::unique_lock<std::recursive_mutex> lock_;
  H5E_auto2_t print_ = nullptr;
  void* print_data_ = nullptr;
};

/// Such as "1.10.8".
std::string library_version();

/// Throws Error with `action` and HDF5's own words when a call failed (a negative result).
template <std::signed_integral Result>
Result checked(Result result, std::string_view action);

/// Owns an identifier.
class Handle {
 public:
  Handle() = default;
  Handle(hid_t id, std::string_view action) : id_(checked(id, action)) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Handle();
  operator hid_t() const { return id_; }

 private:
  hid_t id_ = H5I_INVALID_HID;
};

/// The little-endian type in files and, as salvo only runs on such machines, in memory.
template <class T>
hid_t type_of();

/// Extents of a dataset or attribute; empty for a scalar.
using Extents = std::vector<hsize_t>;

/// A new file that exists in memory only.
class MemoryFile {
 public:
  MemoryFile();
  MemoryFile(MemoryFile&&) = default;
  MemoryFile& operator=(MemoryFile&&) = default;
  operator hid_t() const { return file_; }

  /// The bytes of the file; valid until HDF5 changes it.
  std::span<std::byte> bytes();

 private:
  Handle file_;
};

Handle open_file(const std::filesystem::path& path);
Handle create_group(hid_t parent, const std::string& name);
Handle open_group(hid_t parent, const std::string& name);
void create_soft_link(hid_t parent, const std::string& name, const std::string& target);

void write_all(hid_t dataset, hid_t type, const void* values);
/// A dataset in one piece, to be filled in where offset_of says.
Handle create_dataset(hid_t parent, const std::string& name, hid_t type, const Extents& extents);
/// Where in the file a dataset's values are; nothing for one without values.
std::optional<std::size_t> offset_of(hid_t dataset);
template <class T>
void write_dataset(hid_t parent, const std::string& name, std::span<const T> values) {
  const Handle dataset = create_dataset(parent, name, type_of<T>(), {values.size()});
  write_all(dataset, type_of<T>(), values.data());
}
/// A dataset that reads as `value` everywhere and takes no space.
Handle create_constant_dataset(hid_t parent, const std::string& name, hid_t type,
                               const Extents& extents, const void* value);
/// A dataset of numbers, shuffled and deflated in blocks of `block` numbers, which the caller
/// provides ready-made. The last block is a full one, too; readers ignore what is past the end.
Handle create_deflated_dataset(hid_t parent, const std::string& name, hid_t type, hsize_t count,
                               hsize_t block);
void write_deflated_block(hid_t dataset, hsize_t first, std::span<const std::byte> deflated);
/// Rows of a dataset in another file of the same folder.
struct VirtualPart {
  std::string file;
  hsize_t rows;
};
/// A dataset that shows those of the same path in other files, one after the other. `extents` are
/// its own: the sum of their rows, then what a row has. Where a file is missing, it reads as NaN or
/// the greatest whole number.
Handle create_virtual_dataset(hid_t parent, const std::string& name, hid_t type,
                              const Extents& extents, const std::string& path,
                              std::span<const VirtualPart> parts);
Handle open_dataset(hid_t parent, const std::string& name);
Extents extents_of(hid_t dataset);
Handle type_of_dataset(hid_t dataset);
void read_all(hid_t dataset, hid_t type, void* values);
/// The names of a group's links, sorted.
std::vector<std::string> names_in(hid_t group);
/// The names of an object's attributes, sorted.
std::vector<std::string> attribute_names(hid_t object);

void write_attribute(hid_t object, const std::string& name, hid_t type, const Extents& extents,
                     const void* values);
template <class T>
requires std::is_arithmetic_v<T>
void write_attribute(hid_t object, const std::string& name, T value) {
  write_attribute(object, name, type_of<T>(), {}, &value);
}
template <class T, std::size_t n>
void write_attribute(hid_t object, const std::string& name, const std::array<T, n>& values) {
  write_attribute(object, name, type_of<T>(), {n}, values.data());
}
/// Strings are of fixed length: those of variable length need a heap that readers and equal bytes
/// do well without.
void write_attribute(hid_t object, const std::string& name, std::string_view text);
void write_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts);

void read_attribute(hid_t object, const std::string& name, hid_t type, std::size_t count,
                    void* values);
template <class T>
T read_attribute(hid_t object, const std::string& name) {
  T value;
  read_attribute(object, name, type_of<T>(), 1, &value);
  return value;
}
template <class T, std::size_t n>
std::array<T, n> read_array_attribute(hid_t object, const std::string& name) {
  std::array<T, n> values;
  read_attribute(object, name, type_of<T>(), n, values.data());
  return values;
}
/// Of fixed or, from other programs, variable length.
std::string read_text_attribute(hid_t object, const std::string& name);
std::vector<std::string> read_texts_attribute(hid_t object, const std::string& name);

}  // namespace salvo::recording::hdf5
