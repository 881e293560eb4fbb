// A scene: what to simulate and what to keep of it, read from TOML.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "soa/particle_fields.hpp"
#include "solver/world.hpp"

namespace salvo::scene {

/// Which frames are kept, and what of each.
struct FrameSettings {
  std::int64_t every = 1;  ///< steps between frames; frame 0 is step 0
  std::vector<soa::ParticleField> columns{soa::ParticleField::id, soa::ParticleField::position,
                                          soa::ParticleField::velocity};
  /// Fraction of the particles, chosen by a hash of the id: the same ones in every frame and every
  /// run. 1 keeps all.
  double fraction = 1;
};

struct CheckpointSettings {
  std::int64_t every = 0;  ///< steps between full checkpoints; 0: none on the way
  bool at_end = true;
};

struct VerifySettings {
  std::uint64_t rows = 50000;  ///< emitters are scaled down to at most this many particles
  std::int64_t steps = 0;      ///< 0: all steps of the scene
};

/// What a scene is read from.
struct SceneText {
  std::string path;                    ///< as given on the command line
  std::string text;                    ///< the file, byte for byte
  std::vector<std::string> overrides;  ///< the --set arguments, in order
  std::string title;
  std::vector<solver::Digest> inputs;  ///< of the files that the scene names, in order
};

struct Scene : SceneText {
  solver::Setup setup;
  bool step_chosen = false;  ///< dt follows from the contacts, and was not given
  std::int64_t steps = 0;    ///< the last step; frames are multiples of frames.every up to it
  FrameSettings frames;
  CheckpointSettings checkpoint;
  VerifySettings verify;
  std::string scaling;  ///< what scaled_for_verify changed, such as "50000 of 1000000 particles"

  std::int64_t frame_count() const { return steps / frames.every + 1; }
};

/// The digest of everything that decides the bits: scene text, overrides, and the salvo contract
/// version.
solver::Digest scene_digest(const SceneText& scene);

/// Version of the bits: changes when any scene's bits change on purpose.
inline constexpr int contract_version = 3;

}  // namespace salvo::scene
