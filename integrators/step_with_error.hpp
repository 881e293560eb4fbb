// What a step of a method that knows its error gives.
#pragma once

#include <array>
#include <cstddef>

namespace salvo::integrators {
inline namespace SALVO_ISA {

template <class V, std::size_t N>
struct StepWithError {
  std::array<V, N> result;
  std::array<V, N> error;  ///< an estimate, with its sign
};

}  // namespace SALVO_ISA
}  // namespace salvo::integrators
