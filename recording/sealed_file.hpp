// A file whose last line is the checksum of all bytes before it, so that any change to any byte is
// seen before the file is understood. HDF5 does not look behind the end of what it wrote, so every
// reader still opens the file. By hand:
//
//   head -c -48 frame_000000.hdf | xxh128sum ; tail -c 48 frame_000000.hdf
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "recording/errors.hpp"
#include "recording/output_file.hpp"

namespace salvo::recording {

/// Bytes of the last line.
inline constexpr std::size_t seal_size = 48;

/// Throws OutputError.
void write_sealed(const std::filesystem::path& path, std::span<const std::byte> bytes,
                  Durability durability);

/// Throws CorruptFile when the file is missing, or is not exactly what was sealed.
void verify_seal(const std::filesystem::path& path);

}  // namespace salvo::recording
