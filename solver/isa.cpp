#include "solver/isa.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

namespace salvo::solver {

namespace {

constexpr std::array<std::string_view, 5> names{"scalar", "sse2", "avx2", "avx512", "neon"};

// The compiler's own test, because it also asks the operating system (XCR0) whether it saves the
// wide registers.
bool supported(Isa isa) {
  switch (isa) {
    case Isa::scalar:
      return true;
#if defined(__x86_64__)
    case Isa::sse2:
      return true;
    case Isa::avx2:
      return __builtin_cpu_supports("avx2");
#ifndef SALVO_NO_AVX512
    case Isa::avx512:
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
             __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
             __builtin_cpu_supports("avx512vl");
#endif
#elif defined(__aarch64__)
    case Isa::neon:
      return true;
#endif
    default:
      return false;
  }
}

}  // namespace

std::string_view name(Isa isa) { return names[static_cast<std::size_t>(isa)]; }

std::optional<Isa> isa_named(std::string_view text) {
  const auto* found = std::find(names.begin(), names.end(), text);
  if (found == names.end()) return std::nullopt;
  return static_cast<Isa>(found - names.begin());
}

std::vector<Isa> available_isas() {
  std::vector<Isa> available;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512, Isa::neon}) {
    if (supported(isa)) available.push_back(isa);
  }
  return available;
}

void require_available(Isa isa) {
  const std::vector<Isa> available = available_isas();
  if (std::find(available.begin(), available.end(), isa) == available.end()) {
    throw std::invalid_argument("this machine cannot run the " + std::string(name(isa)) +
                                " kernels");
  }
}

Isa widest_isa() { return available_isas().back(); }

}  // namespace salvo::solver
