// Scenes as they are named on the command line.
#pragma once

#include <string>

#include "cli/options.hpp"
#include "scene/load_sweep.hpp"

namespace salvo::cli {

/// Throws scene::SceneError, and Failure (input_output) when the file cannot be read.
scene::AnyScene load_scene(const std::string& path, const Options& options);

/// "run SCENE --set a=b", quoted for a shell: what a hint tells the user to type.
std::string command_for(const scene::SceneText& scene, const std::string& verb);
std::string shell_quoted(const std::string& word);

}  // namespace salvo::cli
