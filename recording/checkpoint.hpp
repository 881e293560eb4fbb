// Reading a full state back, and finding where a run can go on.
//
// A checkpoint is a frame that holds every stored column of every particle; so is a frame whose
// scene keeps all columns and fraction 1. A run goes on from either with the bits of the
// uninterrupted run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "recording/errors.hpp"
#include "recording/frame.hpp"
#include "scene/scene.hpp"
#include "soa/table.hpp"
#include "solver/world.hpp"

namespace salvo::recording {

struct CheckpointData {
  std::int64_t step = 0;
  soa::Table particles;                ///< sorted by id
  std::optional<soa::Table> contacts;  ///< what they remember, if anything
  solver::ContactTally tally;
  std::uint64_t removed = 0;
  solver::StateHash hash;  ///< recomputed, and equal to the stored one
  solver::Digest scene_digest;

  /// Puts the state into a world of the same scene; the table moves.
  void restore(solver::World& world) &&;
};

/// Reads a checkpoint or a complete frame. Throws CorruptFile (checksum, hash of the state),
/// RecordingError (a frame that holds only a part of the state).
CheckpointData read_checkpoint(const std::filesystem::path& path);

/// Told of every file that was skipped, and why.
using Report = std::function<void(const std::string& message)>;

/// The path of the newest intact checkpoint in a directory, if any.
std::optional<std::filesystem::path> latest_checkpoint(const std::filesystem::path& directory,
                                                       const Report& report = {});

/// The state to go on from so that the directory ends up as that of an uninterrupted run: the
/// newest full state at or before `last_step`, the first missing or damaged frame and the first
/// damaged checkpoint that the scene asks for. Nothing: start at step 0. Throws ForeignRecording
/// when the directory holds another scene's recording.
std::optional<CheckpointData> resume_point(
    const std::filesystem::path& directory, const scene::Scene& scene,
    std::int64_t last_step = std::numeric_limits<std::int64_t>::max(), const Report& report = {});

/// Whether the scene asks for a full checkpoint at a step.
bool checkpoint_due(const scene::Scene& scene, std::int64_t step);

}  // namespace salvo::recording
