#include "soa/aligned_bytes.hpp"

#include <sys/mman.h>

#include <cstdint>
#include <cstring>
#include <new>

namespace salvo::soa {

namespace {

// The C++ library wants to hear the alignment again at the end, so it is the same for all sizes: an
// allocation of huge pages starts where malloc's mapping does and loses the part before the first.
constexpr std::align_val_t aligned{alignment};
constexpr std::size_t huge_from = std::size_t{4} << 20;

void ask_for_huge_pages(std::byte* bytes, std::size_t size) {
#ifdef MADV_HUGEPAGE
  constexpr std::size_t page = 4096;
  const std::size_t before = (page - reinterpret_cast<std::uintptr_t>(bytes) % page) % page;
  if (size < before + page) return;
  // Advice: a kernel that does not take it leaves all as it was.
  ::madvise(bytes + before, (size - before) / page * page, MADV_HUGEPAGE);
#endif
}

}  // namespace

AlignedBytes::AlignedBytes(std::size_t size, std::size_t skew)
    : allocation_(size == 0 ? nullptr
                            : static_cast<std::byte*>(::operator new(size + skew, aligned))),
      size_(size),
      skew_(skew) {
  if (size == 0) return;
  if (size >= huge_from) ask_for_huge_pages(allocation_.get(), size + skew);
  std::memset(data(), 0, size);
}

void AlignedBytes::Release::operator()(std::byte* bytes) const {
  ::operator delete(bytes, aligned);
}

}  // namespace salvo::soa
