// 3x3 matrices over lanes, by rows.
#pragma once

#include "kernels/vec3.hpp"

namespace salvo::kernels {
inline namespace SALVO_ISA {

template <class V>
struct Mat3 {
  Vec3<V> row0, row1, row2;

  static Mat3 identity() { return {{V(1), V(0), V(0)}, {V(0), V(1), V(0)}, {V(0), V(0), V(1)}}; }
  friend Vec3<V> operator*(const Mat3& m, Vec3<V> v) {
    return {dot(m.row0, v), dot(m.row1, v), dot(m.row2, v)};
  }
  friend Mat3 transpose(const Mat3& m) {
    return {{m.row0.x, m.row1.x, m.row2.x},
            {m.row0.y, m.row1.y, m.row2.y},
            {m.row0.z, m.row1.z, m.row2.z}};
  }
  friend Mat3 operator*(const Mat3& a, const Mat3& b) {
    const Mat3 t = transpose(b);
    return {{dot(a.row0, t.row0), dot(a.row0, t.row1), dot(a.row0, t.row2)},
            {dot(a.row1, t.row0), dot(a.row1, t.row1), dot(a.row1, t.row2)},
            {dot(a.row2, t.row0), dot(a.row2, t.row1), dot(a.row2, t.row2)}};
  }
  friend V determinant(const Mat3& m) { return dot(m.row0, cross(m.row1, m.row2)); }
};

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
