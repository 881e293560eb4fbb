// Triangle meshes from files, by the ending of their names: Wavefront OBJ and PLY.
#pragma once

#include <string>

#include "models/triangle_mesh.hpp"
#include "scene/polygon_mesh.hpp"

namespace salvo::scene {

struct MeshFile {
  models::TriangleMesh mesh;  ///< without mistakes (models::mistakes_in), numbers as in the file
  std::string bytes;
};

/// Throws MeshError.
MeshFile read_mesh(const std::string& path);

}  // namespace salvo::scene
