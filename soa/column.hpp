// One aligned array of one field component. Rows are padded to a multiple of 64, four interleaved
// packs of the widest instruction set, so that no kernel has a scalar tail; the padding rows are
// inert, never counted, never hashed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <utility>

#include "soa/aligned_bytes.hpp"

namespace salvo::soa {

/// Rows are padded to a multiple of this.
inline constexpr std::size_t block_rows = 64;

constexpr std::size_t padded(std::size_t rows) {
  return (rows + block_rows - 1) / block_rows * block_rows;
}

/// A column of `element_size`-byte elements. Knows bytes, not types: the table hands out typed
/// pointers.
///
/// Large allocations all start at the same place of a page, so row i of every column of a table
/// would fall into the same set of the L1 cache: eight columns fill its eight ways. Column `number`
/// of a table starts 5 lines further than the one before.
class Column {
 public:
  Column() = default;
  Column(std::size_t element_size, std::size_t number)
      : element_size_(element_size), skew_(number * 5 * alignment) {}

  /// Room for at least `rows`, padding included; keeps the contents, new rows are zero.
  void reserve(std::size_t rows) {
    const std::size_t bytes = padded(rows) * element_size_;
    if (bytes <= storage_.size()) return;
    AlignedBytes larger(bytes, skew_);
    if (storage_.size() != 0) std::memcpy(larger.data(), storage_.data(), storage_.size());
    storage_ = std::move(larger);
  }
  /// Room for rows from `first` to `last`, which are zero.
  void extend(std::size_t first, std::size_t last) {
    // What is new is zero already: pages that nobody writes to are not there yet.
    const std::size_t used_before = storage_.size() / element_size_;
    reserve(last);
    clear_rows(first, std::min(last, used_before));
  }
  void clear_rows(std::size_t first, std::size_t last) {
    if (first < last) {
      std::memset(storage_.data() + first * element_size_, 0, (last - first) * element_size_);
    }
  }
  /// Gives the storage back, with what is in it.
  void release() {
    if (storage_.size() == 0) return;
    released_bytes_ = storage_.size();
    storage_ = {};
  }
  /// Zero in every row that there was, once released.
  void restore() {
    if (storage_.size() == 0) storage_ = AlignedBytes(released_bytes_, skew_);
  }
  std::byte* data() { return storage_.data(); }
  const std::byte* data() const { return storage_.data(); }
  std::size_t element_size() const { return element_size_; }
  std::size_t capacity_bytes() const { return storage_.size(); }

 private:
  std::size_t element_size_ = 0;
  std::size_t skew_ = 0;
  std::size_t released_bytes_ = 0;
  AlignedBytes storage_;
};

}  // namespace salvo::soa
