// A value of a table as a number, whatever its column holds.
#pragma once

#include <cstddef>
#include <cstdint>

#include "soa/table.hpp"

namespace salvo::soa {

/// Of a field of one component. Whole numbers above 2^53 are rounded.
inline double value_at(const Table& table, std::size_t field, std::size_t row) {
  if (!table.stored(field)) return table.uniform(field);
  switch (table.fields()[field].scalar) {
    case Scalar::uint64:
      return static_cast<double>(table.column<std::uint64_t>(field)[row]);
    case Scalar::uint32:
      return static_cast<double>(table.column<std::uint32_t>(field)[row]);
    case Scalar::int32:
      return static_cast<double>(table.column<std::int32_t>(field)[row]);
    case Scalar::real:
      break;
  }
  return table.precision() == Precision::float32
             ? static_cast<double>(table.column<float>(field)[row])
             : table.column<double>(field)[row];
}

}  // namespace salvo::soa
