// Reads frames and checkpoints back. The checksum of the whole file is verified first: a file is
// read whole or refused.
#pragma once

#include <filesystem>

#include "recording/errors.hpp"
#include "recording/frame.hpp"

namespace salvo::recording {

/// Throws CorruptFile.
FrameInfo read_frame_info(const std::filesystem::path& path);

/// All columns. Throws CorruptFile.
Frame read_frame(const std::filesystem::path& path);

}  // namespace salvo::recording
