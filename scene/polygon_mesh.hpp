// A triangle mesh as it is read from a file, polygon after polygon, each with its place in the
// file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "models/triangle_mesh.hpp"

namespace salvo::scene {

/// what() says which place of the file is wrong, and how; hint() what to do.
class MeshError : public std::runtime_error {
 public:
  MeshError(const std::string& problem, std::string hint)
      : std::runtime_error(problem), hint_(std::move(hint)) {}
  const std::string& hint() const { return hint_; }

 private:
  std::string hint_;
};

class PolygonMesh {
 public:
  /// Polygons name their vertices from `first_number` on.
  PolygonMesh(std::string path, std::uint64_t first_number)
      : path_(std::move(path)), first_number_(first_number) {}

  /// The places are byte offsets from now on, no longer lines.
  void count_bytes() { by_byte_ = true; }

  std::size_t vertices() const { return mesh_.vertices.size(); }
  /// Throws MeshError.
  void add_vertex(const models::Triple& position, std::size_t place);
  /// The vertices need not have been added yet. Throws MeshError.
  void add_polygon(std::span<const std::uint64_t> corners, std::size_t place);

  /// The polygons as fans of triangles around their first corners, all in order. Throws MeshError.
  models::TriangleMesh triangulated();

  /// Throws a MeshError about a place.
  [[noreturn]] void fail(std::size_t place, const std::string& problem,
                         const std::string& hint) const;
  /// Throws a MeshError about the whole file.
  [[noreturn]] void fail(const std::string& problem, const std::string& hint) const;

 private:
  struct Polygon {
    std::size_t place;
    std::size_t first, last;  // of corners_
  };

  void add_fan(const Polygon& polygon);
  void check_convexity(std::size_t place, std::size_t first_triangle) const;

  std::string path_;
  std::uint64_t first_number_;
  bool by_byte_ = false;
  models::TriangleMesh mesh_;
  std::vector<Polygon> polygons_;
  std::vector<std::uint64_t> corners_;
  std::vector<std::size_t> places_;  // of the triangles
};

template <class T>
struct ParsedNumber {
  T value{};
  std::string_view problem;  ///< "is no number", "is out of range"; empty: none
};
/// The whole of `word` as a decimal number, whatever the locale.
ParsedNumber<double> parse_real(std::string_view word);
ParsedNumber<std::int64_t> parse_integer(std::string_view word);

/// Cuts the first line off `text`, without its end, LF or CR LF.
std::string_view take_line(std::string_view& text);
/// Cuts the first word off `line`; empty at its end.
std::string_view take_word(std::string_view& line);

}  // namespace salvo::scene
