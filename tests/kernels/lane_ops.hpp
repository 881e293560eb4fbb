// Every operator of a lane behind plain function pointers, for each instruction set. Arrays are
// 64-byte aligned and their length is a multiple of 64.
#pragma once

#include <cstddef>
#include <cstdint>

namespace salvo::tests::lane_ops {

// X(name, expression in V a, b, c, what a NaN result must be: the very bits of an operand, or any
// NaN)
#define SALVO_LANE_OPS(X)                                           \
  X(add, a + b, any_nan)                                            \
  X(subtract, a - b, any_nan)                                       \
  X(multiply, (a * b), any_nan)                                     \
  X(divide, a / b, any_nan)                                         \
  X(square_root, sqrt(a), any_nan)                                  \
  X(negate, -a, same_bits)                                          \
  X(absolute, abs(a), same_bits)                                    \
  X(copy_sign, copysign(a, b), same_bits)                           \
  X(truncate, trunc(a), any_nan)                                    \
  X(round_down, floor(a), any_nan)                                  \
  X(round_up, ceil(a), any_nan)                                     \
  X(round_half_away, round(a), any_nan)                             \
  X(minimum, min(a, b), same_bits)                                  \
  X(maximum, max(a, b), same_bits)                                  \
  X(clamp_to, clamp(a, b, c), same_bits)                            \
  X(product_and_sum, multiply_add(a, b, c), any_nan)                \
  X(choose, select(a < b, c, a), same_bits)                         \
  X(less, select(a < b, V(1), V(0)), same_bits)                     \
  X(less_or_equal, select(a <= b, V(1), V(0)), same_bits)           \
  X(greater, select(a > b, V(1), V(0)), same_bits)                  \
  X(greater_or_equal, select(a >= b, V(1), V(0)), same_bits)        \
  X(equal, select(a == b, V(1), V(0)), same_bits)                   \
  X(not_equal, select(a != b, V(1), V(0)), same_bits)               \
  X(mask_and, select((a < b) & (b < c), V(1), V(0)), same_bits)     \
  X(mask_or, select((a < b) | (b < c), V(1), V(0)), same_bits)      \
  X(mask_not, select(!(a < b), V(1), V(0)), same_bits)              \
  X(mask_constant, select(typename V::Mask(true), a, b), same_bits) \
  X(finite, select(is_finite(a), V(1), V(0)), same_bits)            \
  X(constant, V(0.1) + V(3) * V(-2.5F), same_bits)

enum class Nan { same_bits, any_nan };

enum class Op {
#define SALVO_ENUMERATOR(NAME, EXPRESSION, NAN_RULE) NAME,
  SALVO_LANE_OPS(SALVO_ENUMERATOR)
#undef SALVO_ENUMERATOR
};

struct OpInfo {
  Op op;
  const char* name;
  Nan nan;
};

inline constexpr OpInfo ops[] = {
#define SALVO_INFO(NAME, EXPRESSION, NAN_RULE) {Op::NAME, #NAME, Nan::NAN_RULE},
    SALVO_LANE_OPS(SALVO_INFO)
#undef SALVO_INFO
};

template <class T>
struct Operations {
  std::size_t width;
  /// out[i] = op(a[i], b[i], c[i])
  void (*apply)(Op op, const T* a, const T* b, const T* c, T* out, std::size_t count);
  /// The same through pairs of pairs of packs.
  void (*apply_abreast)(Op op, const T* a, const T* b, const T* c, T* out, std::size_t count);
  /// out[i] = base[index[i]]
  void (*gather)(const T* base, const std::int32_t* index, T* out, std::size_t count);
  /// base[index[i]] = values[i], in ascending i
  void (*scatter)(T* base, const std::int32_t* index, const T* values, std::size_t count);
  /// Of the mask a < b of each pack: its bits, and whether any and all lanes are true.
  void (*masks)(const T* a, const T* b, std::uint32_t* bits, bool* any, bool* all,
                std::size_t count);
};

struct Table {
  Operations<float> single;
  Operations<double> twice;
};

}  // namespace salvo::tests::lane_ops
