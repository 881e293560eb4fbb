// The first difference between two states that should hold the same bits: which row, which column,
// which values. Not a number equals not a number, as in the state hash.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "soa/table.hpp"

namespace salvo::scene {

struct Difference {
  std::int64_t step = 0;        ///< the first step known to differ
  std::int64_t equal_step = 0;  ///< the last step known to be equal; -1: none
  /// Such as "velocity.y"; "id", or "contact" of two, when only one state has the row.
  std::string column;
  std::optional<soa::Id> id;       ///< none: a result of the whole state, such as "impacts"
  std::optional<soa::Id> partner;  ///< in a contact, as in soa::contact_fields
  std::string reference;           ///< hexadecimal floating point, a whole number, or "absent"
  std::string varied;
  std::uint64_t rows = 0;  ///< rows that differ at `step`

  /// False when single steps did not show the difference again: it lies somewhere after
  /// `equal_step`.
  bool exact() const { return step == equal_step + 1; }
};

/// The same bits, or both not a number.
bool same_bits(double a, double b);
bool same_bits(float a, float b);

/// Two tables of the same fields and the same stored columns, particles sorted by id or contacts
/// by id and partner. The lowest that differs, and its first column; steps are left for the caller
/// to fill in.
std::optional<Difference> first_difference(const soa::Table& reference, const soa::Table& varied);

/// The value of a column such as "velocity.y" in the row of an id, as Difference gives it; "absent"
/// without such a row.
std::string value_text(const soa::Table& table, soa::Id id, const std::string& column);

/// A number as Difference gives it: hexadecimal floating point, "inf" or "nan".
std::string hex_text(double value);

}  // namespace salvo::scene
