#include "models/triangle_mesh.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <numeric>
#include <span>
#include <utility>

#include "kernels/shapes.hpp"

namespace salvo::models {

namespace {

using S = kernels::ScalarLane<double>;
using Vec = Vec3<S>;
using Corners = std::array<std::uint32_t, 3>;

constexpr std::uint32_t none = 0xFFFFFFFF;

Vec vec(const Triple& t) { return broadcast<S>(t); }
Triple triple(Vec v) { return {v.x.value(), v.y.value(), v.z.value()}; }
double number(S x) { return x.value(); }

/// By division, so that what lies along an axis has the components 0 and 1.
Vec unit(Vec v) {
  const S length = norm(v);
  return {v.x / length, v.y / length, v.z / length};
}

/// Twice the area of a triangle along its normal.
Vec area_vector(const std::vector<Triple>& vertices, const Corners& t) {
  const Vec a = vec(vertices[t[0]]);
  return cross(vec(vertices[t[1]]) - a, vec(vertices[t[2]]) - a);
}

std::uint32_t index(std::size_t i) { return static_cast<std::uint32_t>(i); }
std::size_t following(std::size_t side) { return (side + 1) % 3; }
std::size_t preceding(std::size_t side) { return (side + 2) % 3; }

/// The triangles with every vertex named by the first one at its position.
std::vector<Corners> welded(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t v) { return mesh.vertices[v]; });
  std::vector<std::uint32_t> first(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool repeats = i > 0 && mesh.vertices[order[i]] == mesh.vertices[order[i - 1]];
    first[order[i]] = repeats ? first[order[i - 1]] : order[i];
  }
  std::vector<Corners> triangles = mesh.triangles;
  for (Corners& t : triangles) {
    for (std::uint32_t& v : t) v = first[v];
  }
  return triangles;
}

/// A side of a triangle: side i runs from corner i to the next.
struct Side {
  std::uint32_t lower, higher;  // numbers of its vertices
  std::uint32_t triangle;
  std::uint32_t side;
};

/// By edge, then by triangle.
std::vector<Side> sorted_sides(const std::vector<Corners>& triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t side = 0; side < 3; ++side) {
      const auto [lower, higher] = std::minmax(triangles[t][side], triangles[t][following(side)]);
      sides.push_back({lower, higher, index(t), index(side)});
    }
  }
  std::ranges::stable_sort(sides, {}, [](const Side& s) { return std::pair(s.lower, s.higher); });
  return sides;
}

/// Calls f with the sides of each edge.
template <class F>
void for_each_edge(std::span<const Side> sides, F f) {
  while (!sides.empty()) {
    std::size_t count = 1;
    while (count < sides.size() && sides[count].lower == sides[0].lower &&
           sides[count].higher == sides[0].higher) {
      ++count;
    }
    f(sides.first(count));
    sides = sides.subspan(count);
  }
}

/// Of each side of each triangle the triangle beyond it, or none.
std::vector<Corners> neighbours(std::span<const Side> sides, std::size_t triangles) {
  std::vector<Corners> beyond(triangles, {none, none, none});
  for_each_edge(sides, [&](std::span<const Side> edge) {
    if (edge.size() != 2) return;
    beyond[edge[0].triangle][edge[0].side] = edge[1].triangle;
    beyond[edge[1].triangle][edge[1].side] = edge[0].triangle;
  });
  return beyond;
}

/// A corner of a triangle.
struct Wedge {
  std::uint32_t vertex, triangle, corner;
};

/// By vertex, then by triangle.
std::vector<Wedge> sorted_wedges(const std::vector<Corners>& triangles) {
  std::vector<Wedge> wedges;
  wedges.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      wedges.push_back({triangles[t][corner], index(t), index(corner)});
    }
  }
  std::ranges::stable_sort(wedges, {}, &Wedge::vertex);
  return wedges;
}

template <class F>
void for_each_vertex(std::span<const Wedge> wedges, F f) {
  while (!wedges.empty()) {
    std::size_t count = 1;
    while (count < wedges.size() && wedges[count].vertex == wedges[0].vertex) ++count;
    f(wedges.first(count));
    wedges = wedges.subspan(count);
  }
}

// ---- mistakes -----------------------------------------------------------------------------------

class Inspection {
 public:
  explicit Inspection(const TriangleMesh& mesh) : mesh_(mesh) {}

  // Each look relies on what the one before it found to be in order.
  std::vector<MeshMistake> mistakes() {
    look_at_numbers();
    if (!mistakes_.empty()) return in_order();
    triangles_ = welded(mesh_);
    look_at_triangles();
    if (!mistakes_.empty()) return in_order();
    sides_ = sorted_sides(triangles_);
    look_at_edges();
    if (!mistakes_.empty()) return in_order();
    look_at_vertices();
    return in_order();
  }

 private:
  void add(std::size_t triangle, std::string problem, std::string hint) {
    mistakes_.push_back({triangle, std::move(problem), std::move(hint)});
  }

  std::vector<MeshMistake> in_order() {
    std::ranges::stable_sort(mistakes_, {}, &MeshMistake::triangle);
    return std::move(mistakes_);
  }

  std::string place(std::uint32_t vertex) const {
    const Triple& p = mesh_.vertices[vertex];
    return fmt::format("({}, {}, {})", p[0], p[1], p[2]);
  }

  void look_at_numbers() {
    if (mesh_.triangles.empty()) {
      mistakes_.push_back({std::nullopt, "the mesh has no triangles", "expected at least one"});
    }
    for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) {
      const Triple& at = mesh_.vertices[v];
      const bool near = std::ranges::all_of(
          at, [](double x) { return -farthest_reach <= x && x <= farthest_reach; });
      if (near) continue;
      mistakes_.push_back(
          {std::nullopt, fmt::format("vertex {} is at {}", v + 1, place(index(v))),
           fmt::format("expected finite coordinates of at most {:g}", farthest_reach)});
    }
    if (mistakes_.empty() && reach(mesh_) < shortest_reach) {
      mistakes_.push_back({std::nullopt, fmt::format("the mesh reaches {:g}", reach(mesh_)),
                           fmt::format("expected a coordinate of at least {:g}", shortest_reach)});
    }
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (const std::uint32_t v : mesh_.triangles[t]) {
        if (v < mesh_.vertices.size()) continue;
        add(t, fmt::format("triangle {} refers to vertex {}", t + 1, std::size_t(v) + 1),
            fmt::format("there are {}", mesh_.vertices.size()));
        break;
      }
    }
  }

  void look_at_triangles() {
    const double least_side = smallest_triangle * reach(mesh_);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const Corners& v = triangles_[t];
      const std::string name = fmt::format("triangle {}", t + 1);
      if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) {
        add(t, fmt::format("{} has two corners at {}", name, place(v[0] == v[1] ? v[0] : v[2])),
            "remove it, or give it three corners");
        continue;
      }
      S longest(0);
      for (std::size_t side = 0; side < 3; ++side) {
        longest = max(longest, norm_squared(vec(mesh_.vertices[v[following(side)]]) -
                                            vec(mesh_.vertices[v[side]])));
      }
      if (!(number(sqrt(longest)) >= least_side)) {
        add(t,
            fmt::format("{} at {} is degenerate: its longest side is {:.3g}", name, place(v[0]),
                        number(sqrt(longest))),
            "remove it");
        continue;
      }
      const double thinness = number(norm(area_vector(mesh_.vertices, v)) / longest);
      if (thinness >= thinnest_triangle) continue;
      add(t,
          fmt::format("{} at {} is degenerate: its height is {:.3g} of its longest side", name,
                      place(v[0]), thinness),
          fmt::format("remove it, or make it no thinner than {:g}", thinnest_triangle));
    }
    look_for_duplicates();
  }

  void look_for_duplicates() {
    std::vector<std::pair<Corners, std::size_t>> sorted;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      Corners corners = triangles_[t];
      std::ranges::stable_sort(corners);
      sorted.emplace_back(corners, t);
    }
    std::ranges::stable_sort(sorted);
    for (std::size_t i = 1; i < sorted.size(); ++i) {
      if (sorted[i].first != sorted[i - 1].first) continue;
      add(sorted[i].second,
          fmt::format("triangle {} has the corners of triangle {}", sorted[i].second + 1,
                      sorted[i - 1].second + 1),
          "remove one of them: a surface has two sides");
    }
  }

  void look_at_edges() {
    for_each_edge(sides_, [&](std::span<const Side> edge) {
      const std::string ends =
          fmt::format("from {} to {}", place(edge[0].lower), place(edge[0].higher));
      if (edge.size() > 2) {
        std::vector<std::size_t> names;
        for (const Side& side : edge) names.push_back(side.triangle + std::size_t(1));
        add(edge.back().triangle,
            fmt::format("triangles {} share the edge {}", fmt::join(names, ", "), ends),
            "expected two at most: move apart the surfaces that meet there");
      } else if (edge.size() == 2 && start(edge[0]) == start(edge[1])) {
        add(edge[1].triangle,
            fmt::format("triangles {} and {} run along their edge {} in the same direction",
                        edge[0].triangle + 1, edge[1].triangle + 1, ends),
            "reverse the order of the vertices of one of them");
      }
    });
  }

  std::uint32_t start(const Side& side) const { return triangles_[side.triangle][side.side]; }

  void look_at_vertices() {
    const std::vector<Corners> beyond = neighbours(sides_, triangles_.size());
    for_each_vertex(sorted_wedges(triangles_), [&](std::span<const Wedge> around) {
      const std::size_t in_fan = fan_size(around[0], beyond);
      if (in_fan == around.size()) return;
      const Wedge& other = *std::ranges::find_if(
          around, [&](const Wedge& w) { return !in_same_fan(around[0], w, beyond); });
      add(other.triangle,
          fmt::format("triangles {} and {} meet at {} only, without a common edge there",
                      around[0].triangle + 1, other.triangle + 1, place(other.vertex)),
          "move apart the surfaces that touch there");
    });
  }

  // The wedges from `first` on around its vertex: counterclockwise, then, at a rim, clockwise.
  template <class F>
  void walk(const Wedge& first, const std::vector<Corners>& beyond, F visit) const {
    visit(first);
    for (const bool counterclockwise : {true, false}) {
      Wedge at = first;
      while (true) {
        const std::size_t crossed = counterclockwise ? preceding(at.corner) : at.corner;
        at.triangle = beyond[at.triangle][crossed];
        if (at.triangle == none) break;
        if (at.triangle == first.triangle) return;
        const Corners& corners = triangles_[at.triangle];
        at.corner = index(std::ranges::find(corners, at.vertex) - corners.begin());
        visit(at);
      }
    }
  }

  std::size_t fan_size(const Wedge& first, const std::vector<Corners>& beyond) const {
    std::size_t count = 0;
    walk(first, beyond, [&](const Wedge&) { ++count; });
    return count;
  }

  bool in_same_fan(const Wedge& first, const Wedge& wanted,
                   const std::vector<Corners>& beyond) const {
    bool found = false;
    walk(first, beyond, [&](const Wedge& w) { found = found || w.triangle == wanted.triangle; });
    return found;
  }

  const TriangleMesh& mesh_;
  std::vector<Corners> triangles_;
  std::vector<Side> sides_;
  std::vector<MeshMistake> mistakes_;
};

// ---- features -----------------------------------------------------------------------------------

class Construction {
 public:
  explicit Construction(const TriangleMesh& mesh)
      : vertices_(mesh.vertices), triangles_(welded(mesh)), sides_(sorted_sides(triangles_)) {
    for (const Corners& t : triangles_) normals_.push_back(unit(area_vector(vertices_, t)));
    find_patches();
    for (std::size_t t = 0; t < triangles_.size(); ++t) add_face(t);
    for_each_edge(sides_, [&](std::span<const Side> edge) { add_edge(edge); });
    add_corners();
  }

  MeshFeatures features() { return std::move(features_); }

 private:
  void find_patches() {
    const std::vector<Corners> beyond = neighbours(sides_, triangles_.size());
    patch_of_.assign(triangles_.size(), none);
    for (std::size_t seed = 0; seed < triangles_.size(); ++seed) {
      if (patch_of_[seed] != none) continue;
      const Vec normal = normals_[seed];
      const Vec across = any_perpendicular(normal);
      const std::uint32_t patch = index(features_.patches.size());
      features_.patches.push_back(
          {vertices_[triangles_[seed][0]], triple(across), triple(cross(normal, across))});
      // All are held against the seed, so that a patch does not follow a gentle bend.
      std::vector<std::size_t> members{seed};
      patch_of_[seed] = patch;
      for (std::size_t i = 0; i < members.size(); ++i) {
        for (const std::uint32_t other : beyond[members[i]]) {
          if (other == none || patch_of_[other] != none) continue;
          const Vec n = normals_[other];
          if (number(norm(cross(normal, n))) > coplanar_angle || number(dot(normal, n)) < 0) {
            continue;
          }
          patch_of_[other] = patch;
          members.push_back(other);
        }
      }
    }
  }

  void add_face(std::size_t t) {
    const Corners& corners = triangles_[t];
    const MeshPatch& patch = features_.patches[patch_of_[t]];
    MeshFace face;
    face.patch = patch_of_[t];
    face.normal = triple(normals_[t]);
    face.height = number(dot(vec(vertices_[corners[0]]) - vec(patch.origin), normals_[t]));
    for (std::size_t i = 0; i < 3; ++i) {
      const PatchView<S> view = view_from(patch, vec(vertices_[corners[i]]));
      face.corners[i] = {number(view.x), number(view.y)};
    }
    for (std::size_t i = 0; i < 3; ++i) {
      face.owned[i] = owns_side(patch, face.corners[i], face.corners[following(i)]);
    }
    features_.faces.push_back(face);
    add_bounds(corners);
  }

  // Whether (e, e^2, e^3) points to the left of a side. An axis that is all but normal to the patch
  // counts as normal to it: what rounding leaves of it must not decide. The sign that it gives to a
  // side along another axis may be either.
  static bool owns_side(const MeshPatch& patch, const PatchPoint& from, const PatchPoint& to) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double x = patch.across[axis];
      const double y = patch.along[axis];
      if (x * x + y * y < 1e-6) continue;
      const double left = y * (to[0] - from[0]) - x * (to[1] - from[1]);
      if (left != 0) return left > 0;
    }
    return false;
  }

  void add_edge(std::span<const Side> sides) {
    if (is_within_patch(sides)) return;
    MeshEdge edge;
    edge.low = vertices_[sides[0].lower];
    edge.high = vertices_[sides[0].higher];
    if (edge.high < edge.low) std::swap(edge.low, edge.high);
    edge.direction = triple(unit(vec(edge.high) - vec(edge.low)));
    edge.side_count = sides.size();
    edge.sides = {};
    for (std::size_t i = 0; i < sides.size(); ++i) {
      const MeshFace& face = features_.faces[sides[i].triangle];
      const std::size_t side = sides[i].side;
      edge.sides[i] = {face.patch, face.corners[side], face.corners[following(side)],
                       face.owned[side]};
    }
    const Vec first = normals_[sides[0].triangle];
    edge.fallback = triple(normalized_or(first + normals_[sides.back().triangle], first));
    features_.edges.push_back(edge);
    add_bounds(std::array{sides[0].lower, sides[0].higher});
  }

  bool is_within_patch(std::span<const Side> sides) const {
    return sides.size() == 2 && patch_of_[sides[0].triangle] == patch_of_[sides[1].triangle];
  }

  void add_corners() {
    // The other ends of the edges of each vertex; whether one of them is a feature.
    std::vector<std::vector<std::uint32_t>> ends(vertices_.size());
    std::vector<bool> stands_out(vertices_.size(), false);
    for_each_edge(sides_, [&](std::span<const Side> edge) {
      ends[edge[0].lower].push_back(edge[0].higher);
      ends[edge[0].higher].push_back(edge[0].lower);
      if (is_within_patch(edge)) return;
      stands_out[edge[0].lower] = true;
      stands_out[edge[0].higher] = true;
    });
    for_each_vertex(sorted_wedges(triangles_), [&](std::span<const Wedge> around) {
      if (stands_out[around[0].vertex]) add_corner(around, ends[around[0].vertex]);
    });
  }

  void add_corner(std::span<const Wedge> around, const std::vector<std::uint32_t>& ends) {
    const std::uint32_t vertex = around[0].vertex;
    const Triple& position = vertices_[vertex];
    std::vector<Triple>& edges = features_.corner_edges;
    MeshCorner corner;
    corner.position = position;
    corner.first = edges.size();
    for (const std::uint32_t end : ends) {
      if (position < vertices_[end]) {
        edges.push_back(triple(unit(vec(vertices_[end]) - vec(position))));
      }
    }
    corner.falling = edges.size();
    // Minus the direction of the edge, to the last bit.
    for (const std::uint32_t end : ends) {
      if (vertices_[end] < position) {
        edges.push_back(triple(-unit(vec(position) - vec(vertices_[end]))));
      }
    }
    corner.last = edges.size();
    Vec sum{S(0), S(0), S(0)};
    for (const Wedge& wedge : around) sum += normals_[wedge.triangle];
    corner.fallback = triple(normalized_or(sum, normals_[around[0].triangle]));
    features_.corners.push_back(corner);
    add_bounds(std::array{vertex});
  }

  void add_bounds(std::span<const std::uint32_t> vertices) {
    MeshBounds bounds{vertices_[vertices[0]], vertices_[vertices[0]]};
    for (const std::uint32_t v : vertices) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double x = vertices_[v][axis];
        if (x < bounds.lowest[axis]) bounds.lowest[axis] = x;
        if (x > bounds.highest[axis]) bounds.highest[axis] = x;
      }
    }
    features_.bounds.push_back(bounds);
  }

  const std::vector<Triple>& vertices_;
  std::vector<Corners> triangles_;
  std::vector<Side> sides_;
  std::vector<Vec> normals_;
  std::vector<std::uint32_t> patch_of_;
  MeshFeatures features_;
};

}  // namespace

double reach(const TriangleMesh& mesh) {
  double farthest = 0;
  for (const Triple& vertex : mesh.vertices) {
    for (const double x : vertex) farthest = std::max({farthest, x, -x});
  }
  return farthest;
}

std::vector<MeshMistake> mistakes_in(const TriangleMesh& mesh) {
  return Inspection(mesh).mistakes();
}

MeshFeatures make_features(const TriangleMesh& mesh) {
  assert(mistakes_in(mesh).empty());
  return Construction(mesh).features();
}

}  // namespace salvo::models
