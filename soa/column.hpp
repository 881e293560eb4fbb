// One aligned array of one field component. Rows are padded to a multiple of 64, four interleaved
// packs of the widest instruction set, so that no kernel has a scalar tail; the padding rows are
// inert, never counted, never hashed.
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>

namespace salvo::soa {

inline constexpr std::size_t alignment = 64;
/// Rows are padded to a multiple of this.
inline constexpr std::size_t block_rows = 64;

constexpr std::size_t padded(std::size_t rows) {
  return (rows + block_rows - 1) / block_rows * block_rows;
}

/// 64-byte aligned, zero-filled storage, `skew` bytes (a multiple of 64) into its allocation.
/// Throws std::bad_alloc.
class AlignedBytes {
 public:
  AlignedBytes() = default;
  explicit AlignedBytes(std::size_t size, std::size_t skew = 0)
      : allocation_(size == 0 ? nullptr
                              : static_cast<std::byte*>(
                                    ::operator new (size + skew, std::align_val_t{alignment}))),
        size_(size),
        skew_(skew) {
    if (size != 0) std::memset(data(), 0, size);
  }
  std::byte* data() { return size_ == 0 ? nullptr : allocation_.get() + skew_; }
  const std::byte* data() const { return size_ == 0 ? nullptr : allocation_.get() + skew_; }
  std::size_t size() const { return size_; }

 private:
  struct Release {
    void operator()(std::byte* bytes) const {
      ::operator delete (bytes, std::align_val_t{alignment});
    }
  };
  std::unique_ptr<std::byte, Release> allocation_;
  std::size_t size_ = 0;
  std::size_t skew_ = 0;
};

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
  void clear_rows(std::size_t first, std::size_t last) {
    if (first < last) {
      std::memset(storage_.data() + first * element_size_, 0, (last - first) * element_size_);
    }
  }
  std::byte* data() { return storage_.data(); }
  const std::byte* data() const { return storage_.data(); }
  std::size_t element_size() const { return element_size_; }
  std::size_t capacity_bytes() const { return storage_.size(); }

 private:
  std::size_t element_size_ = 0;
  std::size_t skew_ = 0;
  AlignedBytes storage_;
};

}  // namespace salvo::soa
