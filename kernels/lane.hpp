// Lane<T, Isa>: one pack of T on one instruction set, limited to the exact set: operations whose
// result IEEE 754 fixes to the last bit, so that every instruction set, compiler and processor
// family gives the same one.
//
// The lane holds an xsimd batch and is not an alias of it, because in xsimd 8.1 some operations
// differ between instruction sets: float division and square root on neon64 are Newton
// approximations, unary minus on AVX-512 is 0 - x and loses the sign of zero, floor, ceil and trunc
// lose -0 on SSE2 and neon64, min and max order NaN differently, NaN != x is false on AVX, and
// bitwise_andnot negates its first argument on x86 and its second on neon64. This is the only file
// that includes xsimd. Lane<T, Scalar> is the specification: plain C++ on one T.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "kernels/isa.hpp"

#if !defined(SALVO_ISA_scalar)
#if defined(__GNUC__) && !defined(__clang__)
// gcc 12 takes the undefined registers of its own AVX-512 intrinsics for forgotten variables.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <xsimd/xsimd.hpp>
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif
#endif
#if defined(SALVO_ISA_neon)
#include <arm_neon.h>
#endif

namespace salvo::kernels {
inline namespace SALVO_ISA {

template <class T, class Isa>
class Lane;
template <class T, class Isa>
class Mask;

// ---- scalar: the specification ------------------------------------------------------------------

/// A truth value per lane.
template <class T>
class Mask<T, Scalar> {
 public:
  Mask() = default;
  explicit Mask(bool value) : value_(value) {}
  bool value() const { return value_; }

  friend Mask operator&(Mask a, Mask b) { return Mask(a.value_ && b.value_); }
  friend Mask operator|(Mask a, Mask b) { return Mask(a.value_ || b.value_); }
  friend Mask operator!(Mask a) { return Mask(!a.value_); }
  friend bool any(Mask a) { return a.value_; }
  friend bool all(Mask a) { return a.value_; }
  /// Bit i is lane i.
  friend std::uint32_t bits(Mask a) { return a.value_ ? 1U : 0U; }

 private:
  bool value_;
};

template <class T>
class Lane<T, Scalar> {
 public:
  using Real = T;
  using Mask = kernels::Mask<T, Scalar>;
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  static constexpr std::size_t width = 1;

  Lane() = default;
  /// The constant in every lane; rounded to T once.
  template <class U>
  requires std::is_arithmetic_v<U> Lane(U constant) : value_(static_cast<T>(constant)) {}

  static Lane load(const T* source) { return Lane(*source); }
  static Lane load_unaligned(const T* source) { return Lane(*source); }
  void store(T* target) const { *target = value_; }
  static Lane gather(const T* base, const std::int32_t* index) { return Lane(base[*index]); }
  void scatter(T* base, const std::int32_t* index) const { base[*index] = value_; }
  T value() const { return value_; }

  friend Lane operator+(Lane a, Lane b) { return Lane(a.value_ + b.value_); }
  friend Lane operator-(Lane a, Lane b) { return Lane(a.value_ - b.value_); }
  friend Lane operator*(Lane a, Lane b) { return Lane(a.value_ * b.value_); }
  friend Lane operator/(Lane a, Lane b) { return Lane(a.value_ / b.value_); }
  friend Lane operator-(Lane a) { return from_bits(a.to_bits() ^ sign_bit); }
  friend Mask operator<(Lane a, Lane b) { return Mask(a.value_ < b.value_); }
  friend Mask operator<=(Lane a, Lane b) { return Mask(a.value_ <= b.value_); }
  friend Mask operator>(Lane a, Lane b) { return Mask(a.value_ > b.value_); }
  friend Mask operator>=(Lane a, Lane b) { return Mask(a.value_ >= b.value_); }
  friend Mask operator==(Lane a, Lane b) { return Mask(a.value_ == b.value_); }
  friend Mask operator!=(Lane a, Lane b) { return Mask(a.value_ != b.value_); }
  friend Lane sqrt(Lane a) { return Lane(std::sqrt(a.value_)); }
  friend Lane abs(Lane a) { return from_bits(a.to_bits() & ~sign_bit); }
  /// The magnitude of a with the sign of b.
  friend Lane copysign(Lane a, Lane b) {
    return from_bits((a.to_bits() & ~sign_bit) | (b.to_bits() & sign_bit));
  }
  friend Lane trunc(Lane a) { return Lane(std::trunc(a.value_)); }
  friend Lane floor(Lane a) { return Lane(std::floor(a.value_)); }
  friend Lane ceil(Lane a) { return Lane(std::ceil(a.value_)); }
  /// a where the mask is true, b elsewhere.
  friend Lane select(Mask m, Lane a, Lane b) { return m.value() ? a : b; }

 private:
  static constexpr Bits sign_bit = Bits(1) << (8 * sizeof(T) - 1);
  static Lane from_bits(Bits bits) { return Lane(std::bit_cast<T>(bits)); }
  Bits to_bits() const { return std::bit_cast<Bits>(value_); }

  T value_;
};

// ---- packs --------------------------------------------------------------------------------------

#if !defined(SALVO_ISA_scalar)

template <class Isa>
struct XsimdArch;
#if defined(SALVO_ISA_neon)
template <>
struct XsimdArch<Neon> {
  using type = xsimd::neon64;
};
#else
template <>
struct XsimdArch<Sse2> {
  using type = xsimd::sse2;
};
#if defined(SALVO_ISA_avx2)
template <>
struct XsimdArch<Avx2> {
  using type = xsimd::avx2;
};
#endif
#if defined(SALVO_ISA_avx512)
template <>
struct XsimdArch<Avx512> {
  using type = xsimd::avx512bw;
};
#endif
#endif

template <class T, class Isa>
class Mask {
 public:
  using Batch = xsimd::batch_bool<T, typename XsimdArch<Isa>::type>;
  Mask() = default;
  explicit Mask(bool value) : batch_(value) {}
  Mask(Batch batch) : batch_(batch) {}
  Batch batch() const { return batch_; }

  friend Mask operator&(Mask a, Mask b) { return a.batch_ & b.batch_; }
  friend Mask operator|(Mask a, Mask b) { return a.batch_ | b.batch_; }
  friend Mask operator!(Mask a) { return ~a.batch_; }
  friend bool any(Mask a) { return xsimd::any(a.batch_); }
  friend bool all(Mask a) { return xsimd::all(a.batch_); }
  /// Bit i is lane i.
  friend std::uint32_t bits(Mask a) {
#if defined(SALVO_ISA_avx512)
    return a.batch_.data;
#elif defined(SALVO_ISA_avx2)
    if constexpr (sizeof(T) == 4) {
      return static_cast<std::uint32_t>(_mm256_movemask_ps(a.batch_));
    } else {
      return static_cast<std::uint32_t>(_mm256_movemask_pd(a.batch_));
    }
#elif defined(SALVO_ISA_sse2)
    if constexpr (sizeof(T) == 4) {
      return static_cast<std::uint32_t>(_mm_movemask_ps(a.batch_));
    } else {
      return static_cast<std::uint32_t>(_mm_movemask_pd(a.batch_));
    }
#else
    alignas(64) bool lanes[Batch::size];
    a.batch_.store_aligned(lanes);
    std::uint32_t result = 0;
    for (std::size_t i = 0; i < Batch::size; ++i) result |= (lanes[i] ? 1U : 0U) << i;
    return result;
#endif
  }

 private:
  Batch batch_;
};

template <class T, class Isa>
class Lane {
 public:
  using Real = T;
  using Mask = kernels::Mask<T, Isa>;
  using Batch = xsimd::batch<T, typename XsimdArch<Isa>::type>;
  static constexpr std::size_t width = Batch::size;

  Lane() = default;
  template <class U>
  requires std::is_arithmetic_v<U> Lane(U constant) : batch_(static_cast<T>(constant)) {}
  Lane(Batch batch) : batch_(batch) {}

  /// 64-byte aligned source of `width` values.
  static Lane load(const T* source) { return Batch::load_aligned(source); }
  static Lane load_unaligned(const T* source) { return Batch::load_unaligned(source); }
  void store(T* target) const { batch_.store_aligned(target); }
  // Through memory, one value at a time: xsimd 8.1 wants 64-bit indices for doubles and scalar
  // loops on most instruction sets anyway; the values are what a hardware gather would load.
  static Lane gather(const T* base, const std::int32_t* index) {
    alignas(64) T values[width];
    for (std::size_t i = 0; i < width; ++i) values[i] = base[index[i]];
    return load(values);
  }
  void scatter(T* base, const std::int32_t* index) const {
    alignas(64) T values[width];
    store(values);
    for (std::size_t i = 0; i < width; ++i) base[index[i]] = values[i];
  }
  Batch batch() const { return batch_; }

  friend Lane operator+(Lane a, Lane b) { return a.batch_ + b.batch_; }
  friend Lane operator-(Lane a, Lane b) { return a.batch_ - b.batch_; }
  friend Lane operator*(Lane a, Lane b) { return a.batch_ * b.batch_; }
  friend Lane operator/(Lane a, Lane b) {
#if defined(SALVO_ISA_neon)
    if constexpr (sizeof(T) == 4) return Batch(vdivq_f32(a.batch_, b.batch_));
#endif
    return a.batch_ / b.batch_;
  }
  // The compiler's own negation, which flips the sign bit and which it can merge into a sum.
  friend Lane operator-(Lane a) { return Batch(-a.batch_.data); }
  friend Mask operator<(Lane a, Lane b) { return a.batch_ < b.batch_; }
  friend Mask operator<=(Lane a, Lane b) { return a.batch_ <= b.batch_; }
  friend Mask operator>(Lane a, Lane b) { return a.batch_ > b.batch_; }
  friend Mask operator>=(Lane a, Lane b) { return a.batch_ >= b.batch_; }
  friend Mask operator==(Lane a, Lane b) { return a.batch_ == b.batch_; }
  // Not xsimd's, which is false for NaN on AVX.
  friend Mask operator!=(Lane a, Lane b) { return !(a == b); }
  friend Lane sqrt(Lane a) {
#if defined(SALVO_ISA_neon)
    if constexpr (sizeof(T) == 4) return Batch(vsqrtq_f32(a.batch_));
#endif
    return xsimd::sqrt(a.batch_);
  }
  friend Lane abs(Lane a) { return a.batch_ & magnitude_bits(); }
  friend Lane copysign(Lane a, Lane b) {
    return (a.batch_ & magnitude_bits()) | (b.batch_ & sign_bit());
  }
  // copysign restores the -0 that xsimd loses on SSE2 and neon64.
  friend Lane trunc(Lane a) { return copysign(Lane(xsimd::trunc(a.batch_)), a); }
  friend Lane floor(Lane a) {
    const Lane whole = trunc(a);
    return copysign(select(whole > a, whole - Lane(1), whole), a);
  }
  friend Lane ceil(Lane a) {
    const Lane whole = trunc(a);
    return copysign(select(whole < a, whole + Lane(1), whole), a);
  }
  friend Lane select(Mask m, Lane a, Lane b) {
    return xsimd::select(m.batch(), a.batch_, b.batch_);
  }

 private:
  using Bits = typename Lane<T, Scalar>::Bits;
  static Batch sign_bit() { return Batch(static_cast<T>(-0.0)); }
  static Batch magnitude_bits() {
    return Batch(std::bit_cast<T>(static_cast<Bits>(~Bits{0} >> 1)));
  }

  Batch batch_;
};

#endif

// ---- in terms of the above ----------------------------------------------------------------------

/// A lane type: Lane, or Pair of lane types.
template <class V>
concept LaneType = requires {
  typename V::Real;
  typename V::Mask;
  V::width;
};

/// The lesser; b where either is NaN. Not the hardware's min: x86 and ARM order NaN and -0
/// differently.
template <LaneType V>
V min(V a, std::type_identity_t<V> b) {
  return select(a < b, a, b);
}

/// The greater; b where either is NaN.
template <LaneType V>
V max(V a, std::type_identity_t<V> b) {
  return select(a > b, a, b);
}

/// x held within [low, high]; NaN becomes low.
template <LaneType V>
V clamp(V x, std::type_identity_t<V> low, std::type_identity_t<V> high) {
  return min(max(x, low), high);
}

/// To the nearest whole number, halves away from zero.
template <LaneType V>
V round(V x) {
  const V whole = trunc(x);
  return copysign(select(abs(x - whole) >= V(0.5), whole + copysign(V(1), x), whole), x);
}

/// a*b + c with both roundings: the exact set has no fused multiply-add.
template <LaneType V>
V multiply_add(V a, std::type_identity_t<V> b, std::type_identity_t<V> c) {
  return a * b + c;
}

/// True where x is neither infinite nor NaN.
template <LaneType V>
typename V::Mask is_finite(V x) {
  return x - x == V(0);
}

/// The lane of this translation unit's instruction set.
template <class T>
using NativeLane = Lane<T, NativeIsa>;

/// One body at a time, in any translation unit: set-up, tests, the specification.
template <class T>
using ScalarLane = Lane<T, Scalar>;

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
