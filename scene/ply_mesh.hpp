// Triangle meshes in PLY files, as text or binary of either byte order.
#pragma once

#include <string>
#include <string_view>

#include "models/triangle_mesh.hpp"

namespace salvo::scene {

/// The mesh in the bytes of the file `path`: the properties x, y and z of its vertices, and the
/// list vertex_indices or vertex_index of its faces, which must be convex. All else is passed over.
/// Throws MeshError.
models::TriangleMesh read_ply(std::string_view bytes, const std::string& path);

}  // namespace salvo::scene
