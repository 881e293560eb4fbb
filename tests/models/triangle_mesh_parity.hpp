// Features of meshes behind plain function pointers, for each instruction set. Columns are 64-byte
// aligned and their length is a multiple of 64.
#pragma once

#include <cstddef>

#include "models/triangle_mesh.hpp"

namespace salvo::tests::triangle_mesh_parity {

template <class T>
struct Look {
  const models::MeshFeatures* mesh = nullptr;
  std::size_t feature = 0;
  std::size_t rows = 0;
  const T* point[3] = {};
  /// Distance, normal, 1 where the feature owns the point.
  T* result[5] = {};
};

struct Table {
  void (*single)(const Look<float>&);
  void (*twice)(const Look<double>&);
};

}  // namespace salvo::tests::triangle_mesh_parity
