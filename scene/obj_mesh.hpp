// Triangle meshes in Wavefront OBJ files: the lines v and f.
#pragma once

#include <string>
#include <string_view>

#include "models/triangle_mesh.hpp"

namespace salvo::scene {

/// The mesh in the text of the file `path`. Faces name vertices from 1 on, or from -1 backwards,
/// with or without texture and normal (7/2/3); those of more than three corners must be convex.
/// Weights and colours of vertices, texture, normals, materials, groups, lines and points are
/// passed over. Throws MeshError.
models::TriangleMesh read_obj(std::string_view text, const std::string& path);

}  // namespace salvo::scene
