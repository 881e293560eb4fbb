// Triangle meshes from files, by the ending of their names: Wavefront OBJ and PLY.
#pragma once

#include <string>

#include "models/triangle_mesh.hpp"
#include "scene/polygon_mesh.hpp"

namespace salvo::scene {

/// A mesh without mistakes (see models::mistakes_in), its numbers as they are in the file. Throws
/// MeshError.
models::TriangleMesh read_mesh(const std::string& path);

}  // namespace salvo::scene
