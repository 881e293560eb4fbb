// Zero-filled storage for columns and for buffers as large as columns. From 4 MiB on it asks for
// huge pages: a step walks a dozen columns at once, and on pages of 4 KiB every 64th cache line of
// each is a miss of the address translation at which the hardware's prefetching also stops. Growing
// such storage faults one page in 512 as often.
#pragma once

#include <cstddef>
#include <memory>

namespace salvo::soa {

inline constexpr std::size_t alignment = 64;

/// 64-byte aligned, zero-filled bytes, `skew` bytes (a multiple of 64) into their allocation.
/// Throws std::bad_alloc.
class AlignedBytes {
 public:
  AlignedBytes() = default;
  explicit AlignedBytes(std::size_t size, std::size_t skew = 0);
  std::byte* data() { return size_ == 0 ? nullptr : allocation_.get() + skew_; }
  const std::byte* data() const { return size_ == 0 ? nullptr : allocation_.get() + skew_; }
  std::size_t size() const { return size_; }

 private:
  struct Release {
    std::size_t mapped;  // bytes of a mapping; 0: of an allocation
    void operator()(std::byte* bytes) const;
  };
  std::unique_ptr<std::byte, Release> allocation_;
  std::size_t size_ = 0;
  std::size_t skew_ = 0;
};

}  // namespace salvo::soa
