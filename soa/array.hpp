// An array that keeps its room: what is sized anew every so often allocates only when it grows.
#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#include "soa/aligned_bytes.hpp"

namespace salvo::soa {

/// Elements hold what was in their place before, zero at first.
template <class T>
class Array {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// Throws std::bad_alloc. What was in it is lost where it has to grow.
  void resize(std::size_t size) {
    if (size * sizeof(T) > bytes_.size()) {
      bytes_ = {};
      bytes_ = AlignedBytes(size * sizeof(T) + size * sizeof(T) / 16);
    }
    size_ = size;
  }
  T* data() { return reinterpret_cast<T*>(bytes_.data()); }
  const T* data() const { return reinterpret_cast<const T*>(bytes_.data()); }
  T& operator[](std::size_t i) { return data()[i]; }
  const T& operator[](std::size_t i) const { return data()[i]; }
  std::size_t size() const { return size_; }
  std::size_t resident_bytes() const { return bytes_.size(); }
  void swap(Array& other) noexcept {
    std::swap(bytes_, other.bytes_);
    std::swap(size_, other.size_);
  }
  void release() {
    bytes_ = {};
    size_ = 0;
  }

 private:
  AlignedBytes bytes_;
  std::size_t size_ = 0;
};

}  // namespace salvo::soa
