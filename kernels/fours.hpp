// Loads of four neighbouring values for each lane, which is what a table of cubics wants: a whole
// row is one load, and the rows are turned into packs in registers. Values are only moved, so the
// bits are those of the plain loop.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "kernels/pair.hpp"

#if defined(SALVO_ISA_avx512) || defined(SALVO_ISA_avx2)
#include <immintrin.h>
#endif

namespace salvo::kernels {
inline namespace SALVO_ISA {

/// Component k of lane i is from[offset[i] + k].
template <class V>
std::array<V, 4> load_fours(const typename V::Real* from, const std::int32_t* offset, const V*) {
  alignas(64) typename V::Real c[4][V::width];
  for (std::size_t lane = 0; lane < V::width; ++lane) {
    for (std::size_t k = 0; k < 4; ++k) c[k][lane] = from[offset[lane] + k];
  }
  return {V::load(c[0]), V::load(c[1]), V::load(c[2]), V::load(c[3])};
}

#if defined(SALVO_ISA_avx512) || defined(SALVO_ISA_avx2)
// Rows 0 to 3 in, components 0 to 3 out.
inline std::array<__m256d, 4> transposed(__m256d r0, __m256d r1, __m256d r2, __m256d r3) {
  const __m256d even_low = _mm256_unpacklo_pd(r0, r1);
  const __m256d odd_low = _mm256_unpackhi_pd(r0, r1);
  const __m256d even_high = _mm256_unpacklo_pd(r2, r3);
  const __m256d odd_high = _mm256_unpackhi_pd(r2, r3);
  return {_mm256_permute2f128_pd(even_low, even_high, 0x20),
          _mm256_permute2f128_pd(odd_low, odd_high, 0x20),
          _mm256_permute2f128_pd(even_low, even_high, 0x31),
          _mm256_permute2f128_pd(odd_low, odd_high, 0x31)};
}
inline std::array<__m256d, 4> four_rows(const double* from, const std::int32_t* offset) {
  return transposed(_mm256_loadu_pd(from + offset[0]), _mm256_loadu_pd(from + offset[1]),
                    _mm256_loadu_pd(from + offset[2]), _mm256_loadu_pd(from + offset[3]));
}
#endif
#if defined(SALVO_ISA_avx2)
inline std::array<Lane<double, Avx2>, 4> load_fours(const double* from, const std::int32_t* offset,
                                                    const Lane<double, Avx2>*) {
  using V = Lane<double, Avx2>;
  const std::array<__m256d, 4> c = four_rows(from, offset);
  return {V(V::Batch(c[0])), V(V::Batch(c[1])), V(V::Batch(c[2])), V(V::Batch(c[3]))};
}
#elif defined(SALVO_ISA_avx512)
inline std::array<Lane<double, Avx512>, 4> load_fours(const double* from,
                                                      const std::int32_t* offset,
                                                      const Lane<double, Avx512>*) {
  using V = Lane<double, Avx512>;
  const std::array<__m256d, 4> low = four_rows(from, offset);
  const std::array<__m256d, 4> high = four_rows(from, offset + 4);
  const auto joined = [&](std::size_t k) {
    return V(V::Batch(_mm512_insertf64x4(_mm512_castpd256_pd512(low[k]), high[k], 1)));
  };
  return {joined(0), joined(1), joined(2), joined(3)};
}
#endif

template <class V>
std::array<Pair<V>, 4> load_fours(const typename V::Real* from, const std::int32_t* offset,
                                  const Pair<V>*) {
  const auto low = load_fours(from, offset, static_cast<const V*>(nullptr));
  const auto high = load_fours(from, offset + V::width, static_cast<const V*>(nullptr));
  return {Pair<V>{low[0], high[0]}, Pair<V>{low[1], high[1]}, Pair<V>{low[2], high[2]},
          Pair<V>{low[3], high[3]}};
}

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
