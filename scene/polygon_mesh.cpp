#include "scene/polygon_mesh.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <system_error>

namespace salvo::scene {

namespace {

template <class T>
ParsedNumber<T> parsed(std::string_view word) {
  // from_chars takes no plus sign.
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  ParsedNumber<T> number;
  const char* const end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, number.value);
  if (error == std::errc::result_out_of_range && stop == end) {
    number.problem = "is out of range";
  } else if (error != std::errc() || stop != end) {
    number.problem = "is no number";
  }
  return number;
}

constexpr std::string_view blanks = " \t\v\f\r";

// A problem quotes the file, which may be anything.
std::string printable(std::string_view problem) {
  constexpr std::size_t longest = 200;
  std::string text;
  for (const char c : problem.substr(0, longest)) {
    if (c >= ' ' && c <= '~') {
      text += c;
    } else {
      text += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    }
  }
  return problem.size() > longest ? text + " ..." : text;
}

}  // namespace

ParsedNumber<double> parse_real(std::string_view word) { return parsed<double>(word); }

ParsedNumber<std::int64_t> parse_integer(std::string_view word) {
  ParsedNumber<std::int64_t> number = parsed<std::int64_t>(word);
  if (number.problem == "is no number") number.problem = "is no whole number";
  return number;
}

std::string_view take_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(blanks));
  line.remove_prefix(word.size());
  return word;
}

void PolygonMesh::fail(std::size_t place, const std::string& problem,
                       const std::string& hint) const {
  throw MeshError(by_byte_ ? fmt::format("{}: byte {}: {}", path_, place, printable(problem))
                           : fmt::format("{}:{}: {}", path_, place, printable(problem)),
                  hint);
}

void PolygonMesh::fail(const std::string& problem, const std::string& hint) const {
  throw MeshError(fmt::format("{}: {}", path_, problem), hint);
}

void PolygonMesh::add_vertex(const models::Triple& position, std::size_t place) {
  for (const double x : position) {
    if (-models::farthest_reach <= x && x <= models::farthest_reach) continue;
    fail(place, fmt::format("a vertex at ({})", fmt::join(position, ", ")),
         fmt::format("expected finite coordinates of at most {:g}", models::farthest_reach));
  }
  mesh_.vertices.push_back(position);
}

void PolygonMesh::add_polygon(std::span<const std::uint64_t> corners, std::size_t place) {
  if (corners.size() < 3) {
    fail(place, fmt::format("a face of {} vertices", corners.size()), "expected at least 3");
  }
  polygons_.push_back({place, corners_.size(), corners_.size() + corners.size()});
  corners_.insert(corners_.end(), corners.begin(), corners.end());
}

models::TriangleMesh PolygonMesh::triangulated() {
  if (vertices() > std::numeric_limits<std::uint32_t>::max()) {
    fail(fmt::format("{} vertices", vertices()), "expected fewer than 2^32");
  }
  for (const Polygon& polygon : polygons_) add_fan(polygon);
  const std::vector<models::MeshMistake> mistakes = models::mistakes_in(mesh_);
  if (mistakes.empty()) return std::move(mesh_);
  const models::MeshMistake& first = mistakes.front();
  const std::string others =
      mistakes.size() > 1 ? fmt::format(" (and {} more)", mistakes.size() - 1) : "";
  if (first.triangle) fail(places_[*first.triangle], first.problem + others, first.hint);
  fail(first.problem + others, first.hint);
}

void PolygonMesh::add_fan(const Polygon& polygon) {
  for (std::size_t i = polygon.first; i < polygon.last; ++i) {
    if (corners_[i] >= first_number_ && corners_[i] - first_number_ < vertices()) continue;
    fail(polygon.place, fmt::format("a face refers to vertex {}", corners_[i]),
         fmt::format("the file has {} vertices, numbered from {}", vertices(), first_number_));
  }
  const auto vertex = [&](std::size_t i) {
    return static_cast<std::uint32_t>(corners_[i] - first_number_);
  };
  const std::size_t first_triangle = mesh_.triangles.size();
  for (std::size_t i = polygon.first + 1; i + 1 < polygon.last; ++i) {
    mesh_.triangles.push_back({vertex(polygon.first), vertex(i), vertex(i + 1)});
    places_.push_back(polygon.place);
  }
  check_convexity(polygon.place, first_triangle);
}

// The triangles of a convex polygon all look the way that their sum does.
void PolygonMesh::check_convexity(std::size_t place, std::size_t first_triangle) const {
  using Vec = kernels::Vec3<double>;
  const auto area = [&](std::size_t t) {
    const auto corner = [&](std::size_t i) -> Vec {
      const models::Triple& p = mesh_.vertices[mesh_.triangles[t][i]];
      return {p[0], p[1], p[2]};
    };
    return cross(corner(1) - corner(0), corner(2) - corner(0));
  };
  Vec sum{0, 0, 0};
  for (std::size_t t = first_triangle; t < mesh_.triangles.size(); ++t) sum += area(t);
  for (std::size_t t = first_triangle; t < mesh_.triangles.size(); ++t) {
    // One without an area is reported where all triangles are.
    if (dot(area(t), sum) > 0 || dot(area(t), area(t)) == 0) continue;
    fail(place, "a face is folded or not convex", "cut it into triangles");
  }
}

}  // namespace salvo::scene
