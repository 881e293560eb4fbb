#include "tests/models/triangle_mesh_parity.hpp"

namespace salvo::tests::triangle_mesh_parity {
inline namespace SALVO_ISA {

namespace {

template <class T>
void look(const Look<T>& l) {
  using V = kernels::NativeLane<T>;
  for (std::size_t at = 0; at < l.rows; at += V::width) {
    const kernels::Vec3<V> p{V::load(l.point[0] + at), V::load(l.point[1] + at),
                             V::load(l.point[2] + at)};
    const auto seen = feature_surface(*l.mesh, l.feature, p);
    seen.distance.store(l.result[0] + at);
    seen.normal.x.store(l.result[1] + at);
    seen.normal.y.store(l.result[2] + at);
    seen.normal.z.store(l.result[3] + at);
    select(seen.owns, V(1), V(0)).store(l.result[4] + at);
  }
}

}  // namespace

extern const Table test_table;
const Table test_table{&look<float>, &look<double>};

}  // namespace SALVO_ISA
}  // namespace salvo::tests::triangle_mesh_parity
