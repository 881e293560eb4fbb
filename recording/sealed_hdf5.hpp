// HDF5 files under a seal.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>
#include <string_view>

#include "recording/hdf5.hpp"
#include "recording/sealed_file.hpp"

namespace salvo::recording {

/// Runs `read` on the verified file. A file that is intact and still not understood is one of
/// another program or version. `what` it should be is named with its article. Throws CorruptFile.
template <class Read>
auto with_sealed_hdf5(const std::filesystem::path& path, std::string_view what, Read read) {
  verify_seal(path);
  const hdf5::Session session;
  try {
    const hdf5::Handle file = hdf5::open_file(path);
    return read(file);
  } catch (const hdf5::Error& error) {
    throw CorruptFile(fmt::format("cannot read {}: it is intact but not {} of this version: {}",
                                  path.string(), what, error.what()));
  } catch (const std::invalid_argument& error) {  // a digest that is none
    throw CorruptFile(fmt::format("cannot read {}: {}", path.string(), error.what()));
  }
}

}  // namespace salvo::recording
