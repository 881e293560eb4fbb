// One aligned array of one field component. Rows are padded to a multiple of 64, four interleaved packs of the widest
// instruction set, so that no kernel has a scalar tail; the padding rows are inert, never counted, never hashed.
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

/// 64-byte aligned, zero-filled storage. Throws std::bad_alloc.
class AlignedBytes {
 public:
  AlignedBytes() = default;
  explicit AlignedBytes(std::size_t size)
      : bytes_(size == 0 ? nullptr
                         : static_cast<std::byte*>(
                               ::operator new(size, std::align_val_t{alignment}))),
        size_(size) {
    if (size != 0) std::memset(bytes_.get(), 0, size);
  }
  std::byte* data() { return bytes_.get(); }
  const std::byte* data() const { return bytes_.get(); }
  std::size_t size() const { return size_; }

 private:
  struct Release {
    void operator()(std::byte* bytes) const {
      ::operator delete(bytes, std::align_val_t{alignment});
    }
  };
  std::unique_ptr<std::byte, Release> bytes_;
  std::size_t size_ = 0;
};

/// A column of `size_of(scalar)`-byte elements. Knows bytes, not types: the table hands out typed pointers.
class Column {
 public:
  Column() = default;
  explicit Column(std::size_t element_size) : element_size_(element_size) {}

  /// Room for at least `rows`, padding included; keeps the contents, new rows are zero.
  void reserve(std::size_t rows) {
    const std::size_t bytes = padded(rows) * element_size_;
    if (bytes <= storage_.size()) return;
    AlignedBytes larger(bytes);
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
  AlignedBytes storage_;
};

}  // namespace salvo::soa
