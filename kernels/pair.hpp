// Pair<V>: two packs side by side as one lane type. Each operation is done on both before the next,
// so that neighbouring instructions do not wait for each other: a processor looks only some hundred
// instructions ahead, too few to reach the next pack past a chain of square roots and divisions.
// Pair<Pair<V>> are four packs. The bits are those of the packs alone.
#pragma once

#include <cstddef>
#include <type_traits>

#include "kernels/math.hpp"

namespace salvo::kernels {
inline namespace SALVO_ISA {

template <class M>
class MaskPair {
 public:
  MaskPair() = default;
  explicit MaskPair(bool value) : low_(value), high_(value) {}
  MaskPair(M low, M high) : low_(low), high_(high) {}
  M low() const { return low_; }
  M high() const { return high_; }

  friend MaskPair operator&(MaskPair a, MaskPair b) { return {a.low_ & b.low_, a.high_ & b.high_}; }
  friend MaskPair operator|(MaskPair a, MaskPair b) { return {a.low_ | b.low_, a.high_ | b.high_}; }
  friend MaskPair operator!(MaskPair a) { return {!a.low_, !a.high_}; }
  friend bool any(MaskPair a) { return any(a.low_ | a.high_); }
  friend bool all(MaskPair a) { return all(a.low_ & a.high_); }

 private:
  M low_;
  M high_;
};

template <class V>
class Pair {
 public:
  using Real = typename V::Real;
  using Mask = MaskPair<typename V::Mask>;
  static constexpr std::size_t width = 2 * V::width;

  Pair() = default;
  template <class U>
  requires std::is_arithmetic_v<U> Pair(U constant) : low_(constant), high_(constant) {}
  Pair(V low, V high) : low_(low), high_(high) {}
  // Written out, because gcc copies a class of two packs through memory.
  Pair(const Pair& other) : low_(other.low_), high_(other.high_) {}
  Pair& operator=(const Pair& other) {
    low_ = other.low_;
    high_ = other.high_;
    return *this;
  }

  static Pair load(const Real* source) { return {V::load(source), V::load(source + V::width)}; }
  void store(Real* target) const {
    low_.store(target);
    high_.store(target + V::width);
  }
  V low() const { return low_; }
  V high() const { return high_; }

  friend Pair operator+(Pair a, Pair b) { return {a.low_ + b.low_, a.high_ + b.high_}; }
  friend Pair operator-(Pair a, Pair b) { return {a.low_ - b.low_, a.high_ - b.high_}; }
  friend Pair operator*(Pair a, Pair b) { return {a.low_ * b.low_, a.high_ * b.high_}; }
  friend Pair operator/(Pair a, Pair b) { return {a.low_ / b.low_, a.high_ / b.high_}; }
  friend Pair operator-(Pair a) { return {-a.low_, -a.high_}; }
  friend Mask operator<(Pair a, Pair b) { return {a.low_ < b.low_, a.high_ < b.high_}; }
  friend Mask operator<=(Pair a, Pair b) { return {a.low_ <= b.low_, a.high_ <= b.high_}; }
  friend Mask operator>(Pair a, Pair b) { return {a.low_ > b.low_, a.high_ > b.high_}; }
  friend Mask operator>=(Pair a, Pair b) { return {a.low_ >= b.low_, a.high_ >= b.high_}; }
  friend Mask operator==(Pair a, Pair b) { return {a.low_ == b.low_, a.high_ == b.high_}; }
  friend Mask operator!=(Pair a, Pair b) { return {a.low_ != b.low_, a.high_ != b.high_}; }
  friend Pair sqrt(Pair a) { return {sqrt(a.low_), sqrt(a.high_)}; }
  friend Pair abs(Pair a) { return {abs(a.low_), abs(a.high_)}; }
  friend Pair copysign(Pair a, Pair b) {
    return {copysign(a.low_, b.low_), copysign(a.high_, b.high_)};
  }
  friend Pair trunc(Pair a) { return {trunc(a.low_), trunc(a.high_)}; }
  friend Pair floor(Pair a) { return {floor(a.low_), floor(a.high_)}; }
  friend Pair ceil(Pair a) { return {ceil(a.low_), ceil(a.high_)}; }
#define SALVO_PAIR_1(NAME) \
  friend Pair NAME(Pair a) { return {NAME(a.low_), NAME(a.high_)}; }
  SALVO_PAIR_1(sin)
  SALVO_PAIR_1(cos)
  SALVO_PAIR_1(tan)
  SALVO_PAIR_1(asin)
  SALVO_PAIR_1(acos)
  SALVO_PAIR_1(atan)
  SALVO_PAIR_1(sinh)
  SALVO_PAIR_1(cosh)
  SALVO_PAIR_1(tanh)
  SALVO_PAIR_1(exp)
  SALVO_PAIR_1(expm1)
  SALVO_PAIR_1(log)
  SALVO_PAIR_1(log1p)
  SALVO_PAIR_1(log10)
  SALVO_PAIR_1(cbrt)
#undef SALVO_PAIR_1
  friend Pair pow(Pair a, Pair b) { return {pow(a.low_, b.low_), pow(a.high_, b.high_)}; }
  friend Pair atan2(Pair a, Pair b) { return {atan2(a.low_, b.low_), atan2(a.high_, b.high_)}; }
  friend Pair select(Mask m, Pair a, Pair b) {
    return {select(m.low(), a.low_, b.low_), select(m.high(), a.high_, b.high_)};
  }

 private:
  V low_;
  V high_;
};

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
