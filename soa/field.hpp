// A field: one line of the one list that drives a table's columns, the scene keys, the recording's
// datasets and attributes, the hash and the documentation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace salvo::soa {

/// How wide the real numbers of a table are.
enum class Precision : std::uint8_t { float32, float64 };

/// What a column holds.
enum class Scalar : std::uint8_t { real, int32, uint32, uint64 };

constexpr std::size_t size_of(Scalar scalar, Precision precision) {
  switch (scalar) {
    case Scalar::real:
      return precision == Precision::float32 ? 4 : 8;
    case Scalar::int32:
    case Scalar::uint32:
      return 4;
    case Scalar::uint64:
      return 8;
  }
  return 0;
}

struct Field {
  std::string_view name;
  Scalar scalar;
  std::size_t components;  ///< 1, or 3 for a vector; every component is a column of its own
  std::string_view unit;   ///< SI, empty for a pure number
  std::string_view meaning;
  double fallback;  ///< the value of a row that nobody set
  double lowest;    ///< smallest accepted value (of each component)
  double highest;   ///< largest accepted value
};

}  // namespace salvo::soa
