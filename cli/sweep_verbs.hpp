// What the commands do with a scene of trajectories.
#pragma once

#include "cli/exit_status.hpp"
#include "cli/json.hpp"
#include "cli/options.hpp"
#include "scene/sweep_scene.hpp"

namespace salvo::cli {

ExitStatus run_sweep(const Options& options, const scene::SweepScene& scene);
ExitStatus hash_sweep(const Options& options, const scene::SweepScene& scene);
ExitStatus verify_sweep(const Options& options, const scene::SweepScene& scene, Json& document);
void describe_sweep(const Options& options, const scene::SweepScene& scene);
/// The CSV file of all rows of a recording.
ExitStatus export_sweep(const Options& options);

}  // namespace salvo::cli
