#include "scene/difference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "soa/contact_fields.hpp"

namespace salvo::scene {

namespace {

constexpr std::array<const char*, 3> axes{".x", ".y", ".z"};

std::string column_name(const soa::Field& field, std::size_t component) {
  std::string name(field.name);
  if (field.components > 1) name += axes[component];
  return name;
}

template <class T>
T value_at(const soa::Table& table, std::size_t field, std::size_t component, std::size_t row) {
  T value;
  std::memcpy(&value, table.bytes(field, component) + row * sizeof(T), sizeof(T));
  return value;
}

template <class T>
bool same_real(const soa::Table& a, std::size_t row_a, const soa::Table& b, std::size_t row_b,
               std::size_t field, std::size_t component) {
  return same_bits(value_at<T>(a, field, component, row_a),
                   value_at<T>(b, field, component, row_b));
}

bool same(const soa::Table& a, std::size_t row_a, const soa::Table& b, std::size_t row_b,
          std::size_t field, std::size_t component) {
  switch (a.fields()[field].scalar) {
    case soa::Scalar::real:
      return a.precision() == soa::Precision::float32
                 ? same_real<float>(a, row_a, b, row_b, field, component)
                 : same_real<double>(a, row_a, b, row_b, field, component);
    case soa::Scalar::int32:
    case soa::Scalar::uint32:
      return value_at<std::uint32_t>(a, field, component, row_a) ==
             value_at<std::uint32_t>(b, field, component, row_b);
    case soa::Scalar::uint64:
      return value_at<std::uint64_t>(a, field, component, row_a) ==
             value_at<std::uint64_t>(b, field, component, row_b);
  }
  return true;
}

std::string text_at(const soa::Table& table, std::size_t field, std::size_t component,
                    std::size_t row) {
  switch (table.fields()[field].scalar) {
    case soa::Scalar::real:
      return hex_text(table.precision() == soa::Precision::float32
                          ? static_cast<double>(value_at<float>(table, field, component, row))
                          : value_at<double>(table, field, component, row));
    case soa::Scalar::int32:
      return fmt::to_string(value_at<std::int32_t>(table, field, component, row));
    case soa::Scalar::uint32:
      return fmt::to_string(value_at<std::uint32_t>(table, field, component, row));
    case soa::Scalar::uint64:
      return fmt::to_string(value_at<std::uint64_t>(table, field, component, row));
  }
  return {};
}

// What names a row: its id, and in a table of contacts also the partner's.
using Key = std::pair<soa::Id, soa::Id>;

bool of_contacts(const soa::Table& table) {
  return table.fields().data() == soa::contact_fields.data();
}

Key key_at(const soa::Table& table, std::size_t row) {
  const auto partner = static_cast<std::size_t>(soa::ContactField::partner);
  return {table.ids()[row],
          of_contacts(table) ? table.column<std::uint64_t>(partner)[row] : soa::Id{}};
}

Difference difference_of(const soa::Table& table, const Key& key) {
  Difference difference;
  difference.id = key.first;
  if (of_contacts(table)) difference.partner = key.second;
  return difference;
}

// The first column in which two rows of one key differ.
std::optional<Difference> row_difference(const soa::Table& a, std::size_t row_a,
                                         const soa::Table& b, std::size_t row_b) {
  for (std::size_t f = 1; f < a.fields().size(); ++f) {
    if (!a.stored(f)) continue;
    for (std::size_t c = 0; c < a.fields()[f].components; ++c) {
      if (same(a, row_a, b, row_b, f, c)) continue;
      Difference difference = difference_of(a, key_at(a, row_a));
      difference.column = column_name(a.fields()[f], c);
      difference.reference = text_at(a, f, c, row_a);
      difference.varied = text_at(b, f, c, row_b);
      return difference;
    }
  }
  return std::nullopt;
}

Difference missing_row(const soa::Table& table, const Key& key, bool in_reference) {
  Difference difference = difference_of(table, key);
  difference.column = table.fields()[0].name;
  const std::string there = difference.partner ? "there" : fmt::to_string(key.first);
  difference.reference = in_reference ? there : "absent";
  difference.varied = in_reference ? "absent" : there;
  return difference;
}

}  // namespace

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (a != a && b != b);
}
bool same_bits(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) || (a != a && b != b);
}

std::optional<Difference> first_difference(const soa::Table& reference, const soa::Table& varied) {
  std::optional<Difference> first;
  std::uint64_t rows = 0;
  std::size_t a = 0;
  std::size_t b = 0;
  while (a < reference.rows() || b < varied.rows()) {
    std::optional<Difference> here;
    const bool a_left = a < reference.rows();
    const bool b_left = b < varied.rows();
    if (a_left && (!b_left || key_at(reference, a) < key_at(varied, b))) {
      here = missing_row(reference, key_at(reference, a++), true);
    } else if (b_left && (!a_left || key_at(varied, b) < key_at(reference, a))) {
      here = missing_row(varied, key_at(varied, b++), false);
    } else {
      here = row_difference(reference, a++, varied, b++);
    }
    if (!here) continue;
    ++rows;
    if (!first) first = std::move(here);
  }
  if (first) first->rows = rows;
  return first;
}

std::string value_text(const soa::Table& table, soa::Id id, const std::string& column) {
  const soa::Id* end = table.ids() + table.rows();
  const soa::Id* found = std::lower_bound(table.ids(), end, id);
  if (found == end || *found != id) return "absent";
  for (std::size_t f = 0; f < table.fields().size(); ++f) {
    for (std::size_t c = 0; table.stored(f) && c < table.fields()[f].components; ++c) {
      if (column_name(table.fields()[f], c) == column) {
        return text_at(table, f, c, static_cast<std::size_t>(found - table.ids()));
      }
    }
  }
  return "absent";
}

std::string hex_text(double value) { return fmt::format("{:a}", value); }

}  // namespace salvo::scene
