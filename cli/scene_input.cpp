#include "cli/scene_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

#include "scene/nearest.hpp"

namespace salvo::cli {

namespace {

// A scene of a similar name in the same folder.
std::string similar_scene(const std::filesystem::path& path) {
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::vector<std::string> names;
  std::error_code ignored;
  for (std::filesystem::directory_iterator entry(folder, ignored), end; !ignored && entry != end;
       entry.increment(ignored)) {
    if (entry->path().extension() == ".toml") names.push_back(entry->path().filename().string());
  }
  std::sort(names.begin(), names.end());
  const std::vector<std::string_view> candidates(names.begin(), names.end());
  const std::string meant = path.filename().string();
  const std::string_view name = scene::nearest(meant, candidates);
  if (name.empty()) return {};
  return fmt::format("did you mean {}?", (path.parent_path() / name).string());
}

}  // namespace

scene::AnyScene load_scene(const std::string& path, const Options& options) {
  try {
    return scene::load_any(path, options.overrides);
  } catch (const std::system_error& error) {
    throw Failure(ExitStatus::input_output,
                  fmt::format("cannot read {}: {}", path, error.code().message()),
                  similar_scene(path));
  }
}

std::string shell_quoted(const std::string& word) {
  constexpr std::string_view plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char letter : word) {
    if (letter == '\'') {
      quoted += "'\\''";
    } else {
      quoted += letter;
    }
  }
  return quoted + "'";
}

std::string command_for(const scene::SceneText& scene, const std::string& verb) {
  std::string command = fmt::format("salvo {} {}", verb, shell_quoted(scene.path));
  for (const std::string& change : scene.overrides) command += " --set " + shell_quoted(change);
  return command;
}

}  // namespace salvo::cli
