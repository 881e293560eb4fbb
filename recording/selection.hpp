// Which particles a frame keeps, and their columns, copied out of the table so that the solver can
// go on.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "soa/aligned_bytes.hpp"
#include "soa/particle_fields.hpp"
#include "soa/table.hpp"
#include "solver/parallel.hpp"

namespace salvo::recording {

/// The output function of SplitMix64: every bit of the id decides every bit of the hash.
constexpr std::uint64_t hash_of_id(soa::Id id) {
  std::uint64_t hash = id + 0x9e3779b97f4a7c15;
  hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9;
  hash = (hash ^ (hash >> 27)) * 0x94d049bb133111eb;
  return hash ^ (hash >> 31);
}

/// A particle is kept when the hash of its id, as a fraction of 2^64, is below the fraction asked
/// for. So the same particles are kept in every frame and every run, and a larger fraction keeps
/// all that a smaller one did.
class Selection {
 public:
  explicit Selection(double fraction)
      : all_(fraction >= 1),
        bound_(all_ ? 0 : static_cast<std::uint64_t>(std::ldexp(fraction, 64))) {}
  bool all() const { return all_; }
  bool keeps(soa::Id id) const { return all_ || hash_of_id(id) < bound_; }

 private:
  bool all_;
  std::uint64_t bound_;
};

/// The columns of one field; null pointers for a uniform one.
struct FieldRows {
  std::size_t field = 0;  ///< index in the table's list
  std::array<const std::byte*, 3> components{};
};

/// Rows of a table, in id order: all that a frame file needs of it.
struct Rows {
  std::size_t count = 0;
  bool complete = false;  ///< all rows and all stored fields
  std::vector<FieldRows> fields;
  std::vector<bool> stored;     ///< a field of the table
  std::vector<double> uniform;  ///< the value of a field that is not
};

/// Views of all stored columns.
Rows all_rows(const soa::Table& table);

/// Buffers that hold copies of the selected rows; reused from frame to frame.
class RowBuffer {
 public:
  /// Copies on the threads of `parallel`. `fields` are indices in the table's list, each at most
  /// once.
  void copy(const soa::Table& table, std::span<const std::size_t> fields,
            const Selection& selection, const solver::Parallel& parallel);
  const Rows& rows() const { return rows_; }
  std::size_t capacity_bytes() const;

 private:
  std::vector<std::size_t> first_row_;  // of each leaf of the table, in the buffer
  std::vector<std::array<soa::AlignedBytes, 3>> columns_;
  Rows rows_;
};

}  // namespace salvo::recording
