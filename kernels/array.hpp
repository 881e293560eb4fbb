// Arrays of lanes made component by component.
#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "kernels/lane.hpp"

namespace salvo::kernels {
inline namespace SALVO_ISA {

/// {f(0), .. f(N - 1)}. Written out by the compiler from the start: the components of an array that
/// a loop fills stay in memory.
template <std::size_t N, class Function>
[[gnu::always_inline]] inline auto array_of(const Function& f) {
  return [&]<std::size_t... I>(std::index_sequence<I...>) __attribute__((always_inline)) {
    return std::array{f(I)...};
  }
  (std::make_index_sequence<N>{});
}

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
