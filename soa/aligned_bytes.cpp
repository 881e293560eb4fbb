#include "soa/aligned_bytes.hpp"

#include <sys/mman.h>

#include <cstdint>
#include <cstring>
#include <new>

namespace salvo::soa {

namespace {

constexpr std::align_val_t aligned{alignment};
constexpr std::size_t huge_page = std::size_t{2} << 20;
constexpr std::size_t huge_from = 2 * huge_page;

// A mapping of its own that starts with a huge page. What an allocator hands out may have been used
// before, and pages that are there already stay small.
std::byte* map(std::size_t size) {
  void* mapped =
      ::mmap(nullptr, size + huge_page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped == MAP_FAILED) throw std::bad_alloc();
  auto* all = static_cast<std::byte*>(mapped);
  const std::size_t before =
      (huge_page - reinterpret_cast<std::uintptr_t>(all) % huge_page) % huge_page;
  if (before > 0) ::munmap(all, before);
  if (before < huge_page) ::munmap(all + before + size, huge_page - before);
#ifdef MADV_HUGEPAGE
  // Advice: a kernel that does not take it leaves all as it was.
  ::madvise(all + before, size, MADV_HUGEPAGE);
#endif
  return all + before;
}

std::size_t whole_pages(std::size_t size) {
  constexpr std::size_t page = std::size_t{64} << 10;  // the largest that small pages are
  return (size + page - 1) / page * page;
}

}  // namespace

AlignedBytes::AlignedBytes(std::size_t size, std::size_t skew) : size_(size), skew_(skew) {
  if (size == 0) return;
  if (size >= huge_from) {
    const std::size_t mapped = whole_pages(size + skew);
    allocation_ = {map(mapped), Release{mapped}};
    return;  // what is mapped is zero
  }
  allocation_ = {static_cast<std::byte*>(::operator new(size + skew, aligned)), Release{0}};
  std::memset(data(), 0, size);
}

void AlignedBytes::Release::operator()(std::byte* bytes) const {
  if (mapped > 0) {
    ::munmap(bytes, mapped);
  } else {
    ::operator delete(bytes, aligned);
  }
}

}  // namespace salvo::soa
