#include "scene/obj_mesh.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "scene/input_table.hpp"
#include "scene/polygon_mesh.hpp"

namespace salvo::scene {

namespace {

// What a surface of flat polygons may come with. Curves and free-form surfaces are not among it:
// passed over, they would be missing.
constexpr std::string_view passed_over[] = {
    "vt",        "vn",     "vp",     "g",     "o",        "s",        "mg",
    "usemtl",    "mtllib", "lod",    "bevel", "c_interp", "d_interp", "shadow_obj",
    "trace_obj", "usemap", "maplib", "l",     "p"};

class ObjReader {
 public:
  explicit ObjReader(const std::string& path) : mesh_(path, 1) {}

  models::TriangleMesh read(std::string_view text) {
    text = without_mark(text);
    std::string joined;
    while (!text.empty()) {
      ++number_;
      std::string_view line = take_line(text);
      place_ = number_;
      // A backslash at its end continues a line.
      joined.clear();
      while (line.ends_with('\\') && !text.empty()) {
        joined.append(line.substr(0, line.size() - 1)).append(" ");
        line = take_line(text);
        ++number_;
      }
      if (!joined.empty()) line = joined.append(line);
      read_line(line.substr(0, line.find('#')));
    }
    return mesh_.triangulated();
  }

 private:
  void read_line(std::string_view line) {
    const std::string_view keyword = take_word(line);
    if (keyword == "v") {
      read_vertex(line);
    } else if (keyword == "f") {
      read_face(line);
    } else if (!keyword.empty() &&
               std::ranges::find(passed_over, keyword) == std::end(passed_over)) {
      mesh_.fail(place_, fmt::format("\"{}\" is no keyword of flat polygons", keyword),
                 fmt::format("expected v or f; passed over are {}", fmt::join(passed_over, ", ")));
    }
  }

  void read_vertex(std::string_view line) {
    std::vector<double> numbers;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      const ParsedNumber<double> number = parse_real(word);
      if (!number.problem.empty()) {
        mesh_.fail(place_, fmt::format("\"{}\" {}", word, number.problem),
                   "expected v X Y Z, decimal numbers");
      }
      numbers.push_back(number.value);
    }
    const std::size_t n = numbers.size();
    if (n != 3 && n != 4 && n != 6 && n != 7) {
      mesh_.fail(place_, fmt::format("a vertex of {} numbers", n),
                 "expected v X Y Z, and a weight or a colour if need be");
    }
    mesh_.add_vertex({numbers[0], numbers[1], numbers[2]}, place_);
  }

  void read_face(std::string_view line) {
    corners_.clear();
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      corners_.push_back(corner(word));
    }
    mesh_.add_polygon(corners_, place_);
  }

  std::uint64_t corner(std::string_view word) const {
    std::string_view rest = word;
    const std::int64_t vertex = reference(rest, word);
    for (int part = 1; !rest.empty(); ++part) {
      rest.remove_prefix(1);  // the slash
      const bool may_be_missing = part == 1 && rest.starts_with('/');
      if (part > 2) refuse(word);
      if (!may_be_missing) reference(rest, word);
    }
    if (vertex > 0) return static_cast<std::uint64_t>(vertex);
    const auto known = static_cast<std::int64_t>(mesh_.vertices());
    if (vertex == 0 || vertex < -known) {
      mesh_.fail(place_, fmt::format("a face refers to vertex {}", vertex),
                 fmt::format("expected numbers from 1 on, or from -1 back to -{}", known));
    }
    return static_cast<std::uint64_t>(known + vertex + 1);
  }

  // Cuts the number before the next slash off `rest`.
  std::int64_t reference(std::string_view& rest, std::string_view word) const {
    const std::string_view digits = rest.substr(0, rest.find('/'));
    rest.remove_prefix(digits.size());
    const ParsedNumber<std::int64_t> number = parse_integer(digits);
    if (!number.problem.empty()) refuse(word);
    return number.value;
  }

  [[noreturn]] void refuse(std::string_view word) const {
    mesh_.fail(place_, fmt::format("\"{}\" is no corner of a face", word),
               "expected VERTEX, VERTEX/TEXTURE, VERTEX//NORMAL or VERTEX/TEXTURE/NORMAL, whole "
               "numbers");
  }

  PolygonMesh mesh_;
  std::size_t number_ = 0;  // of the line
  std::size_t place_ = 0;   // where what is read began
  std::vector<std::uint64_t> corners_;
};

}  // namespace

models::TriangleMesh read_obj(std::string_view text, const std::string& path) {
  return ObjReader(path).read(text);
}

}  // namespace salvo::scene
