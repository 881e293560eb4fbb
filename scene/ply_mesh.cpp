#include "scene/ply_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "scene/polygon_mesh.hpp"

namespace salvo::scene {

namespace {

enum class Encoding { text, little_endian, big_endian };
enum class Kind { whole, natural, real };

struct Type {
  std::string_view name;
  std::string_view long_name;
  std::size_t bytes;
  Kind kind;
};

// The old names and those of fixed width.
constexpr Type types[] = {
    {"char", "int8", 1, Kind::whole},    {"uchar", "uint8", 1, Kind::natural},
    {"short", "int16", 2, Kind::whole},  {"ushort", "uint16", 2, Kind::natural},
    {"int", "int32", 4, Kind::whole},    {"uint", "uint32", 4, Kind::natural},
    {"float", "float32", 4, Kind::real}, {"double", "float64", 8, Kind::real},
};

struct Property {
  std::string name;
  Type type;
  std::optional<Type> count;  // a list
};

struct Element {
  std::string name;
  std::uint64_t rows = 0;
  std::size_t line = 0;
  std::vector<Property> properties;
};

struct Header {
  std::optional<Encoding> encoding;
  std::vector<Element> elements;
  std::size_t lines = 0;
};

constexpr std::string_view formats =
    "expected format ascii 1.0, format binary_little_endian 1.0 or format binary_big_endian 1.0";

class HeaderReader {
 public:
  explicit HeaderReader(const PolygonMesh& mesh) : mesh_(mesh) {}

  /// Cuts the header off `text`.
  Header read(std::string_view& text) {
    header_.lines = 1;
    if (take_line(text) != "ply") fail("the first line is not \"ply\"", "expected a PLY file");
    while (true) {
      if (text.empty()) mesh_.fail("the header has no end", "expected a line end_header");
      ++header_.lines;
      line_ = take_line(text);
      const std::string_view keyword = take_word(line_);
      if (keyword == "end_header") break;
      if (keyword == "comment" || keyword == "obj_info") continue;
      if (keyword == "format") {
        read_format();
      } else if (keyword == "element") {
        read_element();
      } else if (keyword == "property") {
        read_property();
      } else {
        fail(fmt::format("\"{}\" is no keyword of a header", keyword),
             "expected format, comment, obj_info, element, property or end_header");
      }
      if (!take_word(line_).empty()) {
        fail("the line goes on", "expected one declaration a line");
      }
    }
    if (!header_.encoding) mesh_.fail("the header has no format", std::string(formats));
    return header_;
  }

 private:
  [[noreturn]] void fail(const std::string& problem, const std::string& hint) const {
    mesh_.fail(header_.lines, problem, hint);
  }

  void read_format() {
    const std::string_view name = take_word(line_);
    const std::string_view version = take_word(line_);
    if (name == "ascii") header_.encoding = Encoding::text;
    if (name == "binary_little_endian") header_.encoding = Encoding::little_endian;
    if (name == "binary_big_endian") header_.encoding = Encoding::big_endian;
    if (!header_.encoding || version != "1.0") {
      fail(fmt::format("the format is \"{} {}\"", name, version), std::string(formats));
    }
  }

  void read_element() {
    Element element;
    element.name = take_word(line_);
    element.line = header_.lines;
    const std::string_view word = take_word(line_);
    const ParsedNumber<std::int64_t> rows = parse_integer(word);
    if (!rows.problem.empty() || rows.value < 0) {
      fail(fmt::format("\"{}\" is no number of rows", word), "expected element NAME ROWS");
    }
    if (std::ranges::find(header_.elements, element.name, &Element::name) !=
        header_.elements.end()) {
      fail(fmt::format("a second element {}", element.name), "expected names that differ");
    }
    element.rows = static_cast<std::uint64_t>(rows.value);
    header_.elements.push_back(element);
  }

  void read_property() {
    if (header_.elements.empty()) fail("a property of no element", "expected element before it");
    Property property;
    std::string_view word = take_word(line_);
    if (word == "list") {
      property.count = type(take_word(line_));
      if (property.count->kind == Kind::real) {
        fail("the length of a list is no whole number", "expected an integer type, as uchar");
      }
      word = take_word(line_);
    }
    property.type = type(word);
    property.name = take_word(line_);
    std::vector<Property>& properties = header_.elements.back().properties;
    if (property.name.empty()) {
      fail("a property without a name",
           "expected property TYPE NAME or property list TYPE TYPE NAME");
    }
    if (std::ranges::find(properties, property.name, &Property::name) != properties.end()) {
      fail(fmt::format("a second property {}", property.name), "expected names that differ");
    }
    properties.push_back(property);
  }

  Type type(std::string_view word) const {
    for (const Type& known : types) {
      if (word == known.name || word == known.long_name) return known;
    }
    fail(fmt::format("\"{}\" is no type", word),
         "expected char, uchar, short, ushort, int, uint, float or double");
  }

  const PolygonMesh& mesh_;
  Header header_;
  std::string_view line_;
};

/// The rows after the header, value after value.
class Rows {
 public:
  Rows(const PolygonMesh& mesh, const Header& header, std::string_view bytes, std::size_t offset)
      : mesh_(mesh),
        encoding_(*header.encoding),
        bytes_(bytes),
        end_(offset + bytes.size()),
        line_(header.lines) {}

  void begin_row(const Element& element, std::uint64_t row) {
    element_ = &element;
    row_ = row;
    if (encoding_ != Encoding::text) {
      place_ = end_ - bytes_.size();
      return;
    }
    do {
      if (bytes_.empty()) fail_truncated();
      words_ = take_line(bytes_);
      place_ = ++line_;
    } while (words_.find_first_not_of(" \t\r") == std::string_view::npos);
  }

  void end_row() {
    if (encoding_ == Encoding::text && !take_word(words_).empty()) {
      mesh_.fail(place_, fmt::format("the row goes on after the properties of {}", element_->name),
                 "expected one row a line");
    }
  }

  void expect_end() {
    if (encoding_ == Encoding::text) {
      while (!bytes_.empty()) {
        std::string_view line = take_line(bytes_);
        ++line_;
        if (!take_word(line).empty()) fail_surplus(line_);
      }
    }
    if (!bytes_.empty()) fail_surplus(end_ - bytes_.size());
  }

  std::size_t place() const { return place_; }

  double value(const Type& type, const Property& property) {
    if (encoding_ != Encoding::text) return binary_value(type);
    const std::string_view word = take_word(words_);
    if (word.empty()) {
      mesh_.fail(place_, fmt::format("the row ends before property {}", property.name),
                 fmt::format("expected all properties of {}", element_->name));
    }
    return type.kind == Kind::real ? real(word, property) : whole(word, type, property);
  }

 private:
  static std::string hint_of(const Type& type, const Property& property) {
    return fmt::format("property {} is {}{}", property.name, property.count ? "a list of " : "",
                       type.name);
  }

  double real(std::string_view word, const Property& property) const {
    const ParsedNumber<double> number = parse_real(word);
    if (!number.problem.empty()) {
      mesh_.fail(place_, fmt::format("\"{}\" {}", word, number.problem),
                 hint_of(property.type, property));
    }
    return number.value;
  }

  double whole(std::string_view word, const Type& type, const Property& property) const {
    ParsedNumber<std::int64_t> number = parse_integer(word);
    const std::int64_t values = std::int64_t{1} << (8 * type.bytes);
    const std::int64_t lowest = type.kind == Kind::natural ? 0 : -values / 2;
    if (number.problem.empty() && (number.value < lowest || number.value >= lowest + values)) {
      number.problem = "is out of range";
    }
    if (!number.problem.empty()) {
      mesh_.fail(place_, fmt::format("\"{}\" {}", word, number.problem), hint_of(type, property));
    }
    return static_cast<double>(number.value);
  }

  double binary_value(const Type& type) {
    if (bytes_.size() < type.bytes) fail_truncated();
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < type.bytes; ++i) {
      const std::size_t at = encoding_ == Encoding::big_endian ? i : type.bytes - 1 - i;
      bits = bits << 8 | static_cast<unsigned char>(bytes_[at]);
    }
    bytes_.remove_prefix(type.bytes);
    if (type.kind == Kind::real) {
      return type.bytes == 4
                 ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)))
                 : std::bit_cast<double>(bits);
    }
    const std::uint64_t sign = std::uint64_t{1} << (8 * type.bytes - 1);
    if (type.kind == Kind::natural || bits < sign) return static_cast<double>(bits);
    return static_cast<double>(bits) - 2 * static_cast<double>(sign);
  }

  [[noreturn]] void fail_truncated() const {
    const std::string problem = fmt::format("the file ends in row {} of {} of element {}", row_ + 1,
                                            element_->rows, element_->name);
    mesh_.fail(encoding_ == Encoding::text ? line_ : end_, problem,
               "it is cut off, or its header is wrong");
  }

  [[noreturn]] void fail_surplus(std::size_t place) const {
    mesh_.fail(place, "the file goes on after its last element",
               "the header announces too few rows");
  }

  const PolygonMesh& mesh_;
  Encoding encoding_;
  std::string_view bytes_;
  std::size_t end_;         // length of the file
  std::size_t line_;        // that was read last
  std::string_view words_;  // what is left of it
  std::size_t place_ = 0;   // of the row
  const Element* element_ = nullptr;
  std::uint64_t row_ = 0;
};

class PlyReader {
 public:
  explicit PlyReader(const std::string& path) : mesh_(path, 0) {}

  models::TriangleMesh read(std::string_view bytes) {
    const std::size_t length = bytes.size();
    const Header header = HeaderReader(mesh_).read(bytes);
    find_columns(header);
    if (*header.encoding != Encoding::text) mesh_.count_bytes();
    Rows rows(mesh_, header, bytes, length - bytes.size());
    for (const Element& element : header.elements) {
      if (element.properties.empty()) continue;  // its rows are nothing, however many
      for (std::uint64_t row = 0; row < element.rows; ++row) {
        rows.begin_row(element, row);
        read_row(element, rows);
        rows.end_row();
      }
    }
    rows.expect_end();
    return mesh_.triangulated();
  }

 private:
  void find_columns(const Header& header) {
    for (const char* const axis : {"x", "y", "z"}) {
      const Property& property = wanted(header, "vertex", {axis});
      if (property.count) {
        mesh_.fail(fmt::format("property {} of its vertices is a list", axis),
                   fmt::format("expected property float {}", axis));
      }
    }
    const Property& property = wanted(header, "face", {"vertex_indices", "vertex_index"});
    if (!property.count || property.type.kind == Kind::real) {
      mesh_.fail(fmt::format("property {} of its faces is no list of whole numbers", property.name),
                 fmt::format("expected property list uchar int {}", property.name));
    }
    corners_name_ = property.name;
  }

  const Property& wanted(const Header& header, std::string_view element_name,
                         std::vector<std::string_view> names) const {
    const auto element = std::ranges::find(header.elements, element_name, &Element::name);
    if (element == header.elements.end()) {
      mesh_.fail(fmt::format("it has no element {}", element_name), "expected vertices and faces");
    }
    for (const std::string_view name : names) {
      const auto property = std::ranges::find(element->properties, name, &Property::name);
      if (property != element->properties.end()) return *property;
    }
    mesh_.fail(element->line, fmt::format("element {} has no property {}", element_name, names[0]),
               element_name == "face" ? "expected property list uchar int vertex_indices"
                                      : "expected x, y and z");
  }

  void read_row(const Element& element, Rows& rows) {
    const bool is_vertex = element.name == "vertex";
    models::Triple position{};
    for (const Property& property : element.properties) {
      if (property.count) {
        read_list(element, property, rows);
        continue;
      }
      const double value = rows.value(property.type, property);
      if (!is_vertex || property.name.size() != 1) continue;
      const char letter = property.name[0];
      if (letter < 'x' || letter > 'z') continue;
      position[static_cast<std::size_t>(letter - 'x')] = value;
    }
    if (is_vertex) mesh_.add_vertex(position, rows.place());
  }

  void read_list(const Element& element, const Property& property, Rows& rows) {
    const bool is_polygon = element.name == "face" && property.name == corners_name_;
    const double length = rows.value(*property.count, property);
    if (length < 0) {
      mesh_.fail(rows.place(), fmt::format("property {} has {} values", property.name, length),
                 "the file is damaged, or its header is wrong");
    }
    corners_.clear();
    for (double i = 0; i < length; ++i) {
      const double value = rows.value(property.type, property);
      if (!is_polygon) continue;
      if (value < 0) {
        mesh_.fail(rows.place(), fmt::format("a face refers to vertex {}", value),
                   "expected numbers from 0 on");
      }
      corners_.push_back(static_cast<std::uint64_t>(value));
    }
    if (is_polygon) mesh_.add_polygon(corners_, rows.place());
  }

  PolygonMesh mesh_;
  std::string corners_name_;
  std::vector<std::uint64_t> corners_;
};

}  // namespace

models::TriangleMesh read_ply(std::string_view bytes, const std::string& path) {
  return PlyReader(path).read(bytes);
}

}  // namespace salvo::scene
