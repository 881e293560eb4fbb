#include "scene/mesh_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "scene/obj_mesh.hpp"
#include "scene/ply_mesh.hpp"

namespace salvo::scene {

namespace {

std::string text_of(const std::string& path) {
  const auto refuse = [&](int error) {
    throw MeshError(fmt::format("cannot read {}: {}", path, std::generic_category().message(error)),
                    "its path is relative to the scene's");
  };
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) refuse(errno != 0 ? errno : ENOENT);
  std::ostringstream text;
  text << file.rdbuf();
  // A folder opens, but gives nothing.
  if (file.bad() || (text.fail() && errno != 0)) refuse(errno != 0 ? errno : EIO);
  return std::move(text).str();
}

}  // namespace

MeshFile read_mesh(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& letter : ending) {
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  }
  if (ending != ".obj" && ending != ".ply") {
    throw MeshError(fmt::format("{} is no mesh by its name", path),
                    "expected a file that ends in .obj or .ply");
  }
  std::string bytes = text_of(path);
  models::TriangleMesh mesh = ending == ".obj" ? read_obj(bytes, path) : read_ply(bytes, path);
  return {std::move(mesh), std::move(bytes)};
}

}  // namespace salvo::scene
