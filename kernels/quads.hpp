// Loads and stores of four neighboring numbers of a record for each lane: where a sphere is and
// what else it has are a few such quads, each one load, and they are turned into packs in
// registers. Values are only moved, so the bits are those of the plain loop.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "kernels/lane.hpp"

#if defined(SALVO_ISA_sse2) || defined(SALVO_ISA_avx512) || defined(SALVO_ISA_avx2)
#include <immintrin.h>
#endif

namespace salvo::kernels {
inline namespace SALVO_ISA {

template <class V>
using Quad = std::array<V, 4>;

/// Component k of lane i is from[index[i] * Stride + k]. `from` is aligned to four numbers, and so
/// is the stride.
template <std::size_t Stride, class V>
[[gnu::always_inline]] inline Quad<V> load_quad(const typename V::Real* from,
                                                const std::int32_t* index, const V*) {
  alignas(64) typename V::Real c[4][V::width];
  for (std::size_t lane = 0; lane < V::width; ++lane) {
    const auto* record = from + static_cast<std::size_t>(index[lane]) * Stride;
    for (std::size_t k = 0; k < 4; ++k) c[k][lane] = record[k];
  }
  return {V::load(c[0]), V::load(c[1]), V::load(c[2]), V::load(c[3])};
}

/// The reverse for records in a row: lane i goes to to[i * Stride].
template <std::size_t Stride, class V>
[[gnu::always_inline]] inline void store_quad(const Quad<V>& quad, typename V::Real* to) {
  alignas(64) typename V::Real c[4][V::width];
  for (std::size_t k = 0; k < 4; ++k) quad[k].store(c[k]);
  for (std::size_t lane = 0; lane < V::width; ++lane) {
    for (std::size_t k = 0; k < 4; ++k) to[lane * Stride + k] = c[k][lane];
  }
}

#if defined(SALVO_ISA_sse2) || defined(SALVO_ISA_avx512) || defined(SALVO_ISA_avx2)
// Rows 0 to 3 in, columns 0 to 3 out, in each 128 bits; its own inverse.
#define SALVO_TRANSPOSE(PREFIX, REGISTER)                                               \
  inline std::array<REGISTER, 4> quad_transposed(REGISTER r0, REGISTER r1, REGISTER r2, \
                                                 REGISTER r3) {                         \
    const auto low = PREFIX##_castps_pd(PREFIX##_unpacklo_ps(r0, r1));                  \
    const auto high = PREFIX##_castps_pd(PREFIX##_unpackhi_ps(r0, r1));                 \
    const auto next_low = PREFIX##_castps_pd(PREFIX##_unpacklo_ps(r2, r3));             \
    const auto next_high = PREFIX##_castps_pd(PREFIX##_unpackhi_ps(r2, r3));            \
    return {PREFIX##_castpd_ps(PREFIX##_unpacklo_pd(low, next_low)),                    \
            PREFIX##_castpd_ps(PREFIX##_unpackhi_pd(low, next_low)),                    \
            PREFIX##_castpd_ps(PREFIX##_unpacklo_pd(high, next_high)),                  \
            PREFIX##_castpd_ps(PREFIX##_unpackhi_pd(high, next_high))};                 \
  }
#endif

#if defined(SALVO_ISA_sse2)
SALVO_TRANSPOSE(_mm, __m128)
template <std::size_t Stride>
[[gnu::always_inline]] inline Quad<Lane<float, Sse2>> load_quad(const float* from,
                                                                const std::int32_t* index,
                                                                const Lane<float, Sse2>*) {
  using B = Lane<float, Sse2>::Batch;
  const auto row = [&](std::size_t i) {
    return _mm_load_ps(from + static_cast<std::size_t>(index[i]) * Stride);
  };
  const auto c = quad_transposed(row(0), row(1), row(2), row(3));
  return {B(c[0]), B(c[1]), B(c[2]), B(c[3])};
}
template <std::size_t Stride>
[[gnu::always_inline]] inline void store_quad(const Quad<Lane<float, Sse2>>& quad, float* to) {
  const auto r =
      quad_transposed(quad[0].batch(), quad[1].batch(), quad[2].batch(), quad[3].batch());
  for (std::size_t i = 0; i < 4; ++i) _mm_store_ps(to + i * Stride, r[i]);
}
#elif defined(SALVO_ISA_avx2)
SALVO_TRANSPOSE(_mm256, __m256)
template <std::size_t Stride>
[[gnu::always_inline]] inline Quad<Lane<float, Avx2>> load_quad(const float* from,
                                                                const std::int32_t* index,
                                                                const Lane<float, Avx2>*) {
  using B = Lane<float, Avx2>::Batch;
  const auto rows = [&](std::size_t i) {
    const float* low = from + static_cast<std::size_t>(index[i]) * Stride;
    const float* high = from + static_cast<std::size_t>(index[i + 4]) * Stride;
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(low)), _mm_load_ps(high), 1);
  };
  const auto c = quad_transposed(rows(0), rows(1), rows(2), rows(3));
  return {B(c[0]), B(c[1]), B(c[2]), B(c[3])};
}
template <std::size_t Stride>
[[gnu::always_inline]] inline void store_quad(const Quad<Lane<float, Avx2>>& quad, float* to) {
  const auto r =
      quad_transposed(quad[0].batch(), quad[1].batch(), quad[2].batch(), quad[3].batch());
  for (std::size_t i = 0; i < 4; ++i) {
    _mm_store_ps(to + i * Stride, _mm256_castps256_ps128(r[i]));
    _mm_store_ps(to + (i + 4) * Stride, _mm256_extractf128_ps(r[i], 1));
  }
}
#elif defined(SALVO_ISA_avx512)
SALVO_TRANSPOSE(_mm512, __m512)
template <std::size_t Stride>
[[gnu::always_inline]] inline Quad<Lane<float, Avx512>> load_quad(const float* from,
                                                                  const std::int32_t* index,
                                                                  const Lane<float, Avx512>*) {
  using B = Lane<float, Avx512>::Batch;
  const auto rows = [&](std::size_t i) {
    const auto row = [&](std::size_t lane) {
      return _mm_load_ps(from + static_cast<std::size_t>(index[lane]) * Stride);
    };
    __m512 r = _mm512_castps128_ps512(row(i));
    r = _mm512_insertf32x4(r, row(i + 4), 1);
    r = _mm512_insertf32x4(r, row(i + 8), 2);
    return _mm512_insertf32x4(r, row(i + 12), 3);
  };
  const auto c = quad_transposed(rows(0), rows(1), rows(2), rows(3));
  return {B(c[0]), B(c[1]), B(c[2]), B(c[3])};
}
template <std::size_t Stride>
[[gnu::always_inline]] inline void store_quad(const Quad<Lane<float, Avx512>>& quad, float* to) {
  const auto r =
      quad_transposed(quad[0].batch(), quad[1].batch(), quad[2].batch(), quad[3].batch());
  for (std::size_t i = 0; i < 4; ++i) {
    _mm_store_ps(to + i * Stride, _mm512_castps512_ps128(r[i]));
    _mm_store_ps(to + (i + 4) * Stride, _mm512_extractf32x4_ps(r[i], 1));
    _mm_store_ps(to + (i + 8) * Stride, _mm512_extractf32x4_ps(r[i], 2));
    _mm_store_ps(to + (i + 12) * Stride, _mm512_extractf32x4_ps(r[i], 3));
  }
}
#endif
#undef SALVO_TRANSPOSE

#if defined(SALVO_ISA_avx2) || defined(SALVO_ISA_avx512)
inline std::array<__m256d, 4> quad_transposed(__m256d r0, __m256d r1, __m256d r2, __m256d r3) {
  const __m256d even_low = _mm256_unpacklo_pd(r0, r1);
  const __m256d odd_low = _mm256_unpackhi_pd(r0, r1);
  const __m256d even_high = _mm256_unpacklo_pd(r2, r3);
  const __m256d odd_high = _mm256_unpackhi_pd(r2, r3);
  return {_mm256_permute2f128_pd(even_low, even_high, 0x20),
          _mm256_permute2f128_pd(odd_low, odd_high, 0x20),
          _mm256_permute2f128_pd(even_low, even_high, 0x31),
          _mm256_permute2f128_pd(odd_low, odd_high, 0x31)};
}
template <std::size_t Stride>
[[gnu::always_inline]] inline std::array<__m256d, 4> quad_of_four(const double* from,
                                                                  const std::int32_t* index) {
  const auto row = [&](std::size_t i) {
    return _mm256_load_pd(from + static_cast<std::size_t>(index[i]) * Stride);
  };
  return quad_transposed(row(0), row(1), row(2), row(3));
}
#endif
#if defined(SALVO_ISA_avx2)
template <std::size_t Stride>
[[gnu::always_inline]] inline Quad<Lane<double, Avx2>> load_quad(const double* from,
                                                                 const std::int32_t* index,
                                                                 const Lane<double, Avx2>*) {
  using B = Lane<double, Avx2>::Batch;
  const auto c = quad_of_four<Stride>(from, index);
  return {B(c[0]), B(c[1]), B(c[2]), B(c[3])};
}
template <std::size_t Stride>
[[gnu::always_inline]] inline void store_quad(const Quad<Lane<double, Avx2>>& quad, double* to) {
  const auto r =
      quad_transposed(quad[0].batch(), quad[1].batch(), quad[2].batch(), quad[3].batch());
  for (std::size_t i = 0; i < 4; ++i) _mm256_store_pd(to + i * Stride, r[i]);
}
#elif defined(SALVO_ISA_avx512)
template <std::size_t Stride>
[[gnu::always_inline]] inline Quad<Lane<double, Avx512>> load_quad(const double* from,
                                                                   const std::int32_t* index,
                                                                   const Lane<double, Avx512>*) {
  using B = Lane<double, Avx512>::Batch;
  const auto low = quad_of_four<Stride>(from, index);
  const auto high = quad_of_four<Stride>(from, index + 4);
  const auto joined = [&](std::size_t k) {
    return B(_mm512_insertf64x4(_mm512_castpd256_pd512(low[k]), high[k], 1));
  };
  return {joined(0), joined(1), joined(2), joined(3)};
}
template <std::size_t Stride>
[[gnu::always_inline]] inline void store_quad(const Quad<Lane<double, Avx512>>& quad, double* to) {
  const auto low = [&](std::size_t k) { return _mm512_castpd512_pd256(quad[k].batch()); };
  const auto high = [&](std::size_t k) { return _mm512_extractf64x4_pd(quad[k].batch(), 1); };
  const auto first = quad_transposed(low(0), low(1), low(2), low(3));
  const auto second = quad_transposed(high(0), high(1), high(2), high(3));
  for (std::size_t i = 0; i < 4; ++i) {
    _mm256_store_pd(to + i * Stride, first[i]);
    _mm256_store_pd(to + (i + 4) * Stride, second[i]);
  }
}
#endif

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
