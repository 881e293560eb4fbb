// Whose recording a directory holds. Files of another scene, or that salvo did not write, are never
// replaced unasked.
#pragma once

#include <filesystem>
#include <optional>

#include "recording/errors.hpp"
#include "solver/state_hash.hpp"

namespace salvo::recording {

/// The scene digest that run.json, else a frame or checkpoint, tells; nothing when there is none
/// that can be read.
std::optional<solver::Digest> recorded_scene(const std::filesystem::path& directory);

/// Throws ForeignRecording unless the directory holds nothing that looks like a recording, or one
/// of the scene of this digest.
void check_ownership(const std::filesystem::path& directory, const solver::Digest& scene);

/// Keeps a second run from recording into the same directory; released when the process ends,
/// however it ends.
class DirectoryLock {
 public:
  /// Throws OutputError when another run holds it.
  explicit DirectoryLock(const std::filesystem::path& directory);
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace salvo::recording
