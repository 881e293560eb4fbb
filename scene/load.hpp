// Reading scenes: TOML to Scene. Everything that is wrong with a file is found in one go and said
// in one form:
//
//   scene.toml:5:1: error: unknown key "sped" in [[emitter]]
//     5 | sped = 120
//       | ^^^^ did you mean "speed"?
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace salvo::scene {

/// A scene that cannot be run as it is written. what() is the text of all its mistakes, in the
/// order of the file.
class SceneError : public std::runtime_error {
 public:
  explicit SceneError(std::vector<std::string> mistakes);
  /// One text each, of one or more lines, without a newline at the end.
  const std::vector<std::string>& mistakes() const { return mistakes_; }

 private:
  std::vector<std::string> mistakes_;
};

/// The scene of a file. `overrides` are "key.path=value" with the value as in TOML
/// ("emitter.0.count=10" reaches into the list of emitters); a value that is no TOML, and any
/// value of a key that takes a string, is taken as it stands, so that quotes may be left out.
/// Throws SceneError, and std::system_error when the file cannot be read.
Scene load(const std::string& path, const std::vector<std::string>& overrides = {});

/// The bytes of a scene's file. Throws std::system_error.
std::string read_scene_file(const std::string& path);

/// The scene of a text; `path` is the name that messages give it.
Scene parse(const std::string& text, const std::string& path,
            const std::vector<std::string>& overrides = {});

/// The scene at the size at which it is verified: emitters scaled down in proportion to at most
/// verify.rows particles (at least one each), and at most verify.steps steps. `scaling` of the
/// result says what was changed, if anything was.
Scene scaled_for_verify(const Scene& scene);

/// Every key of a scene of either kind, with unit, meaning, default and bounds, as Markdown.
std::string key_reference();

}  // namespace salvo::scene
