// Whether a scene fits in this machine's memory, known before anything is allocated or written.
#pragma once

#include <cstdint>
#include <optional>

#include "scene/scene.hpp"
#include "scene/sweep_scene.hpp"

namespace salvo::cli {

/// Bytes that this program can take without swapping, within the limits of its container; nothing
/// where the system does not say.
std::optional<std::uint64_t> available_memory();

/// Bytes a run takes: its state and, when recorded, the frames and checkpoints on their way to the
/// disk.
std::uint64_t run_bytes(const scene::Scene& scene, bool recorded);
/// About the bytes of the file of one frame, and of one checkpoint, when all particles are alive.
std::uint64_t frame_bytes(const scene::Scene& scene);
std::uint64_t checkpoint_bytes(const scene::Scene& scene);

/// Throws Failure (run_failed) that says how much `bytes` is and what there is.
void check_memory(const scene::Scene& scene, std::uint64_t bytes);
void check_memory(const scene::SweepScene& scene, std::uint64_t bytes);

}  // namespace salvo::cli
