// Numbers that arithmetic stumbles over, and how to compare results bit by bit.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <random>
#include <type_traits>
#include <vector>

#include "soa/column.hpp"

namespace salvo::tests {

template <class T>
using BitsOf = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;

template <class T>
BitsOf<T> bits_of(T value) {
  return std::bit_cast<BitsOf<T>>(value);
}

/// The bits, with every NaN the same one.
template <class T>
BitsOf<T> canonical_bits(T value) {
  return value == value ? bits_of(value) : bits_of(std::numeric_limits<T>::quiet_NaN());
}

/// Allocates as the columns of a table do, so that packs load whole.
template <class T>
struct Aligned {
  using value_type = T;
  Aligned() = default;
  template <class U>
  Aligned(const Aligned<U>&) {}
  T* allocate(std::size_t count) {
    return static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{soa::alignment}));
  }
  void deallocate(T* values, std::size_t) {
    ::operator delete (values, std::align_val_t{soa::alignment});
  }
  friend bool operator==(Aligned, Aligned) { return true; }
};
template <class T>
using AlignedVector = std::vector<T, Aligned<T>>;

/// Both signs of zeros, denormals, the edges of rounding and of the range, infinities, NaNs with
/// different payloads, and random bit patterns.
template <class T>
std::vector<T> special_values() {
  using Limits = std::numeric_limits<T>;
  using Bits = BitsOf<T>;
  constexpr Bits quiet = Bits{1} << (Limits::digits - 2);
  std::vector<T> values;
  for (const T magnitude :
       {T(0),
        Limits::denorm_min(),
        Limits::denorm_min() * T(3),
        Limits::min() / T(2),
        Limits::min(),
        Limits::min() * T(1.5),
        Limits::epsilon(),
        T(0.1),
        T(0.5),
        T(0.75),
        T(1),
        T(1) + Limits::epsilon(),
        T(1.5),
        T(2.5),
        T(3),
        T(1e4),
        T(0x1p23),
        T(0x1p23) - T(0.5),
        T(0x1p24) + T(2),
        T(0x1p31),
        T(0x1p52),
        T(0x1p52) - T(0.5),
        T(0x1p53),
        T(0x1p63),
        Limits::max() / T(2),
        Limits::max(),
        Limits::infinity(),
        Limits::quiet_NaN(),
        std::bit_cast<T>(static_cast<Bits>(bits_of(Limits::quiet_NaN()) | 0x155)),
        std::bit_cast<T>(static_cast<Bits>(bits_of(Limits::infinity()) | 0x2A)),  // signalling
        std::bit_cast<T>(static_cast<Bits>(bits_of(Limits::infinity()) | quiet))}) {
    values.push_back(magnitude);
    values.push_back(
        std::bit_cast<T>(static_cast<Bits>(bits_of(magnitude) | Bits{1} << (sizeof(T) * 8 - 1))));
  }
  std::mt19937_64 random(20);
  for (int i = 0; i < 85; ++i) values.push_back(std::bit_cast<T>(static_cast<Bits>(random())));
  return values;
}

}  // namespace salvo::tests
