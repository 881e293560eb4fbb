// Triangle meshes as obstacles of spheres: the surface as faces, edges and corners, each of which
// answers only for the points that are nearest to it. A sphere thus touches a floor of many
// triangles once, the two walls of a groove twice, and a rim where it is.
//
// The regions are those of Voronoi, as every triangle around a feature sees them. A face owns the
// points whose perpendicular foot lies inside the triangle. An edge owns those between its ends
// that lie beyond it as seen from each of its triangles; a corner those beyond the end of each of
// its edges. Of a feature that is nearest to a point, all this is true; of the others it is true
// where they are nearer than all that is around them. Surfaces have two sides, so the far wall of a
// solid answers too, from behind and at its own distance.
//
// Borders. Neighbours decide by one expression of one rounding, the one by its being true, the
// other by its being false, so no gap opens between them and no strip belongs to both. A point on a
// border belongs to whom (x + e, y + e^2, z + e^3) belongs to as e goes to zero, which is the rule
// by which rasterizers fill every pixel once. Triangles of one plane are one patch: all of them see
// a point at the same place of the plane, so exactly one of them owns it, even above a vertex that
// many share, and there are no features between them. Only where an edge ends, patches and edges of
// several directions meet: next to the plane through the end, by no more than the rounding of the
// point, two features may answer, and next to the line above a corner none.
//
// The alternative, the nearest point of every triangle, touches a floor once a triangle; sorting
// the doubles out afterwards needs a tolerance, and a list of contacts that knows its neighbours.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kernels/vec3.hpp"
#include "models/force_settings.hpp"
#include "models/particle.hpp"

namespace salvo::models {

struct TriangleMesh {
  std::vector<Triple> vertices;  // m
  /// Numbers of vertices, counterclockwise as seen from where the normal points to. Vertices at the
  /// same position count as one.
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// How far the vertices of a mesh may reach from its origin along an axis, and must: the squares of
/// areas are numbers.
inline constexpr double farthest_reach = 1e30;
inline constexpr double shortest_reach = 1e-30;
/// Triangles whose sides are less than this part of the mesh's reach are points.
inline constexpr double smallest_triangle = 1e-30;

/// The largest coordinate, either way.
double reach(const TriangleMesh& mesh);

/// Triangles whose height is less than this part of their longest side have no normal to speak of.
inline constexpr double thinnest_triangle = 1e-6;

/// Neighbours whose normals differ by less than this angle are of one plane, in rad: coordinates
/// that were written with six digits are that exact. From one to the other the normal jumps by no
/// more than twice the angle, the distance by less than 1e-8 of itself.
inline constexpr double coplanar_angle = 1e-4;

/// What is wrong with a mesh. In the text, triangles and vertices count from 1.
struct MeshMistake {
  std::optional<std::size_t> triangle;  ///< that it was found at, from 0
  std::string problem;
  std::string hint;  ///< what to do
};

/// Everything that keeps a mesh from being an obstacle, in the order of the triangles: coordinates
/// that are not finite and vertices that do not exist; else degenerate triangles and duplicates;
/// else edges of more than two triangles or of two that face opposite sides; else vertices at which
/// surfaces meet that share no edge there. A mesh may be open: edges of one triangle are no
/// mistake.
std::vector<MeshMistake> mistakes_in(const TriangleMesh& mesh);

/// A point in the plane of a patch, from its origin along its axes. m
using PatchPoint = std::array<double, 2>;

/// The plane of neighbouring triangles, by a point and two axes of it, which with the normal are
/// right-handed.
struct MeshPatch {
  Triple origin;
  Triple across, along;
};

/// A side of a triangle, which lies to its left.
struct MeshSide {
  std::size_t patch;
  PatchPoint from, to;
  bool owned;  ///< points on it belong to the triangle
};

struct MeshFace {
  std::size_t patch;
  Triple normal;  ///< of this triangle alone; that of the patch differs by rounding or little more
  double height;  ///< along the normal, above the patch's origin
  std::array<PatchPoint, 3> corners;
  std::array<bool, 3> owned;  ///< side i, from corner i to the next: as MeshSide::owned
};

/// Where two patches meet, or one ends.
struct MeshEdge {
  Triple low, high;  ///< its ends, by x, then y, then z
  Triple direction;  ///< unit vector from low to high
  Triple fallback;   ///< the normal on the edge itself
  std::array<MeshSide, 2> sides;
  std::size_t side_count;  ///< 1 at the rim of an open mesh
};

struct MeshCorner {
  Triple position;
  Triple fallback;  ///< the normal at the corner itself
  /// Of MeshFeatures::corner_edges: [first, falling) rise along x, else along y, else along z;
  /// [falling, last) fall.
  std::size_t first, falling, last;
};

struct MeshBounds {
  Triple lowest, highest;
};

/// The features of a mesh: first the faces, triangle by triangle; then the edges, by the numbers of
/// their vertices; then the corners, by vertex. Of vertices at the same position the first counts.
struct MeshFeatures {
  std::vector<MeshPatch> patches;
  std::vector<MeshFace> faces;
  std::vector<MeshEdge> edges;
  std::vector<MeshCorner> corners;
  /// Unit vectors away from the corners, along all edges that meet there.
  std::vector<Triple> corner_edges;
  /// Of each feature. A point that a feature owns at the distance d is no farther than d (1 + 1e-8)
  /// from its bounds, but for the rounding of the point.
  std::vector<MeshBounds> bounds;

  std::size_t size() const { return faces.size() + edges.size() + corners.size(); }
};

/// Of a mesh without mistakes.
MeshFeatures make_features(const TriangleMesh& mesh);

inline namespace SALVO_ISA {

/// A feature as seen from a point. Where the point is not the feature's own, distance and normal
/// are finite and mean nothing.
template <class V>
struct FeatureSurface {
  V distance;      // m, not negative: a surface has two sides
  Vec3<V> normal;  // unit, from the surface to the point
  typename V::Mask owns;
};

/// A point as seen from a patch.
template <class V>
struct PatchView {
  Vec3<V> from_origin;
  V x, y;  // along the axes
};

template <class V>
PatchView<V> view_from(const MeshPatch& patch, Vec3<V> p) {
  const Vec3<V> r = p - broadcast<V>(patch.origin);
  return {r, dot(r, broadcast<V>(patch.across)), dot(r, broadcast<V>(patch.along))};
}

/// True where the point lies to the left of a side, or on it if the side is owned. The ends as seen
/// from the point, not the side as seen from an end: all sides that meet at a vertex then share the
/// rounding next to it, and one wedge between them owns the point. The neighbour's side runs the
/// other way, which changes the sign of the product and no other bit.
template <class V>
typename V::Mask is_inside(const PatchPoint& from, const PatchPoint& to, bool owned,
                           const PatchView<V>& point) {
  const V from_x = V(from[0]) - point.x;
  const V from_y = V(from[1]) - point.y;
  const V to_x = V(to[0]) - point.x;
  const V to_y = V(to[1]) - point.y;
  const V left = from_x * to_y - from_y * to_x;
  return owned ? left >= V(0) : left > V(0);
}

template <class V>
FeatureSurface<V> face_surface(const MeshFace& face, const MeshPatch& patch, Vec3<V> p) {
  const PatchView<V> point = view_from(patch, p);
  const auto& [a, b, c] = face.corners;
  const auto owns = is_inside(a, b, face.owned[0], point) & is_inside(b, c, face.owned[1], point) &
                    is_inside(c, a, face.owned[2], point);
  const Vec3<V> normal = broadcast<V>(face.normal);
  const V height = dot(point.from_origin, normal) - V(face.height);
  return {abs(height), select(height < V(0), -normal, normal), owns};
}

/// Of an edge or a corner, whose nearest point is `from_nearest` away.
template <class V>
FeatureSurface<V> point_surface(Vec3<V> from_nearest, const Triple& fallback,
                                typename V::Mask owns) {
  const V distance = norm(from_nearest);
  const auto apart = distance > V(0);
  const V divisor = select(apart, distance, V(1));
  const Vec3<V> away{from_nearest.x / divisor, from_nearest.y / divisor, from_nearest.z / divisor};
  return {distance, select(apart, away, broadcast<V>(fallback)), owns};
}

template <class V>
FeatureSurface<V> edge_surface(const MeshEdge& edge, const std::vector<MeshPatch>& patches,
                               Vec3<V> p) {
  const Vec3<V> direction = broadcast<V>(edge.direction);
  const Vec3<V> from_low = p - broadcast<V>(edge.low);
  const V along = dot(from_low, direction);
  auto owns = (along >= V(0)) & (dot(p - broadcast<V>(edge.high), direction) < V(0));
  for (std::size_t i = 0; i < edge.side_count; ++i) {
    const MeshSide& side = edge.sides[i];
    owns = owns & !is_inside(side.from, side.to, side.owned, view_from(patches[side.patch], p));
  }
  return point_surface(from_low - direction * along, edge.fallback, owns);
}

template <class V>
FeatureSurface<V> corner_surface(const MeshCorner& corner, const std::vector<Triple>& edges,
                                 Vec3<V> p) {
  const Vec3<V> from_corner = p - broadcast<V>(corner.position);
  typename V::Mask owns(true);
  for (std::size_t i = corner.first; i < corner.last; ++i) {
    const V along = dot(from_corner, broadcast<V>(edges[i]));
    owns = owns & (i < corner.falling ? along < V(0) : along <= V(0));
  }
  return point_surface(from_corner, corner.fallback, owns);
}

/// The feature of the given number as seen from p, in m from the origin of the mesh, along its own
/// axes: what moves is the frame around a mesh.
template <class V>
FeatureSurface<V> feature_surface(const MeshFeatures& mesh, std::size_t feature, Vec3<V> p) {
  if (feature < mesh.faces.size()) {
    const MeshFace& face = mesh.faces[feature];
    return face_surface(face, mesh.patches[face.patch], p);
  }
  feature -= mesh.faces.size();
  if (feature < mesh.edges.size()) return edge_surface(mesh.edges[feature], mesh.patches, p);
  return corner_surface(mesh.corners[feature - mesh.edges.size()], mesh.corner_edges, p);
}

}  // namespace SALVO_ISA
}  // namespace salvo::models
