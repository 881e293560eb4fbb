// Parity of operations: every operator of a lane over every pair of special values gives the scalar
// lane's bits on every instruction set, and the scalar lane gives what IEEE 754 asks for, computed
// by MPFR.
#include "tests/kernels/lane_ops.hpp"

#include <gtest/gtest.h>
#include <mpfr.h>

#include <cmath>
#include <ios>

#include "tests/kernels/values.hpp"
#include "tests/per_isa.hpp"

namespace salvo::tests {

namespace lane_ops {
SALVO_TEST_TABLES
}

namespace {

using lane_ops::Nan;
using lane_ops::Op;
using lane_ops::Operations;
using lane_ops::OpInfo;

// MPFR as an IEEE format: its precision and exponent range, denormals included, rounding to
// nearest.
template <class T>
class Ieee {
 public:
  Ieee() {
    constexpr bool single = sizeof(T) == 4;
    mpfr_set_emin(single ? -148 : -1073);
    mpfr_set_emax(single ? 128 : 1024);
    for (auto* number : {&a_, &b_, &result_}) mpfr_init2(*number, single ? 24 : 53);
  }
  ~Ieee() {
    for (auto* number : {&a_, &b_, &result_}) mpfr_clear(*number);
    mpfr_set_emin(mpfr_get_emin_min());
    mpfr_set_emax(mpfr_get_emax_max());
  }
  Ieee(const Ieee&) = delete;
  Ieee& operator=(const Ieee&) = delete;

  using Unary = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
  using Binary = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t);

  T operator()(Unary function, T a) {
    set(a_, a);
    return finish(function(result_, a_, MPFR_RNDN));
  }
  T operator()(Binary function, T a, T b) {
    set(a_, a);
    set(b_, b);
    return finish(function(result_, a_, b_, MPFR_RNDN));
  }

 private:
  static void set(mpfr_ptr to, T value) { mpfr_set_d(to, static_cast<double>(value), MPFR_RNDN); }
  T finish(int ternary) {
    mpfr_subnormalize(result_, ternary, MPFR_RNDN);
    return static_cast<T>(mpfr_get_d(result_, MPFR_RNDN));
  }
  mpfr_t a_, b_, result_;
};

template <class T>
T with_sign_of(T magnitude, T sign) {
  constexpr BitsOf<T> top = BitsOf<T>{1} << (sizeof(T) * 8 - 1);
  return std::bit_cast<T>(
      static_cast<BitsOf<T>>((bits_of(magnitude) & ~top) | (bits_of(sign) & top)));
}

// What the operator must give, from MPFR, from comparisons of plain numbers, or from the bits.
template <class T>
T reference(Ieee<T>& ieee, Op op, T a, T b, T c) {
  const auto flag = [](bool value) { return value ? T(1) : T(0); };
  const auto higher = [](T x, T y) { return x > y ? x : y; };
  switch (op) {
    case Op::add:
      return ieee(mpfr_add, a, b);
    case Op::subtract:
      return ieee(mpfr_sub, a, b);
    case Op::multiply:
      return ieee(mpfr_mul, a, b);
    case Op::divide:
      return ieee(mpfr_div, a, b);
    case Op::square_root:
      return ieee(mpfr_sqrt, a);
    case Op::negate:
      return with_sign_of(a, std::signbit(a) ? T(1) : T(-1));
    case Op::absolute:
      return with_sign_of(a, T(1));
    case Op::copy_sign:
      return with_sign_of(a, b);
    case Op::truncate:
      return ieee(mpfr_rint_trunc, a);
    case Op::round_down:
      return ieee(mpfr_rint_floor, a);
    case Op::round_up:
      return ieee(mpfr_rint_ceil, a);
    case Op::round_half_away:
      return ieee(mpfr_rint_round, a);
    case Op::minimum:
      return a < b ? a : b;
    case Op::maximum:
      return higher(a, b);
    case Op::clamp_to:
      return higher(a, b) < c ? higher(a, b) : c;
    case Op::product_and_sum:
      return ieee(mpfr_add, ieee(mpfr_mul, a, b), c);
    case Op::choose:
      return a < b ? c : a;
    case Op::less:
      return flag(a < b);
    case Op::less_or_equal:
      return flag(a <= b);
    case Op::greater:
      return flag(a > b);
    case Op::greater_or_equal:
      return flag(a >= b);
    case Op::equal:
      return flag(a == b);
    case Op::not_equal:
      return flag(a != b);
    case Op::mask_and:
      return flag(a < b && b < c);
    case Op::mask_or:
      return flag(a < b || b < c);
    case Op::mask_not:
      return flag(!(a < b));
    case Op::mask_constant:
      return a;
    case Op::finite:
      return flag(std::isfinite(a));
    case Op::constant:
      return ieee(mpfr_add, static_cast<T>(0.1), T(-7.5));
  }
  return T(0);
}

// All pairs of special values; the third operand walks through them with a stride of its own.
template <class T>
struct Operands {
  AlignedVector<T> a, b, c;

  Operands() {
    const std::vector<T> values = special_values<T>();
    for (std::size_t i = 0; i < values.size(); ++i) {
      for (std::size_t j = 0; j < values.size(); ++j) {
        a.push_back(values[i]);
        b.push_back(values[j]);
        c.push_back(values[(7 * i + 3 * j) % values.size()]);
      }
    }
    for (AlignedVector<T>* column : {&a, &b, &c}) column->resize(soa::padded(column->size()), T(1));
  }
  std::size_t size() const { return a.size(); }
};

template <class T>
const Operations<T>& operations(solver::Isa isa) {
  if constexpr (sizeof(T) == 4) {
    return lane_ops::table_of(isa).single;
  } else {
    return lane_ops::table_of(isa).twice;
  }
}

template <class T>
class LaneOps : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(LaneOps, Reals);

// Names the first operands on which two results differ.
template <class T>
void expect_same(const OpInfo& info, const char* who, const Operands<T>& operands,
                 const AlignedVector<T>& got, const AlignedVector<T>& wanted) {
  const auto key = [&](T value) {
    return info.nan == Nan::same_bits ? bits_of(value) : canonical_bits(value);
  };
  for (std::size_t i = 0; i < got.size(); ++i) {
    if (key(got[i]) == key(wanted[i])) continue;
    ADD_FAILURE() << info.name << " on " << who << ": a = " << operands.a[i]
                  << ", b = " << operands.b[i] << ", c = " << operands.c[i] << " gives " << got[i]
                  << " (" << std::hex << bits_of(got[i]) << "), not " << wanted[i] << " ("
                  << bits_of(wanted[i]) << ")";
    return;
  }
}

}  // namespace

TYPED_TEST(LaneOps, ScalarIsIeee754) {
  using T = TypeParam;
  const Operands<T> operands;
  Ieee<T> ieee;
  AlignedVector<T> got(operands.size());
  AlignedVector<T> wanted(operands.size());
  for (const OpInfo& info : lane_ops::ops) {
    operations<T>(solver::Isa::scalar)
        .apply(info.op, operands.a.data(), operands.b.data(), operands.c.data(), got.data(),
               got.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      wanted[i] = reference(ieee, info.op, operands.a[i], operands.b[i], operands.c[i]);
    }
    expect_same(info, "scalar", operands, got, wanted);
  }
}

TYPED_TEST(LaneOps, EveryInstructionSetIsScalar) {
  using T = TypeParam;
  const Operands<T> operands;
  AlignedVector<T> got(operands.size());
  AlignedVector<T> wanted(operands.size());
  for (const solver::Isa isa : solver::available_isas()) {
    for (const OpInfo& info : lane_ops::ops) {
      const auto run = [&](solver::Isa which, AlignedVector<T>& out) {
        operations<T>(which).apply(info.op, operands.a.data(), operands.b.data(), operands.c.data(),
                                   out.data(), out.size());
      };
      run(solver::Isa::scalar, wanted);
      run(isa, got);
      expect_same(info, std::string(name(isa)).c_str(), operands, got, wanted);
      operations<T>(isa).apply_abreast(info.op, operands.a.data(), operands.b.data(),
                                       operands.c.data(), got.data(), got.size());
      expect_same(info, (std::string(name(isa)) + ", four packs").c_str(), operands, got, wanted);
    }
  }
}

TYPED_TEST(LaneOps, MaskBitsAnyAndAllAgreeWithComparisons) {
  using T = TypeParam;
  Operands<T> operands;
  for (std::size_t i = 0; i < 64; ++i) operands.a[i] = T(-1);  // packs that are all true
  for (std::size_t i = 0; i < 64; ++i) operands.b[i] = T(3);
  for (const solver::Isa isa : solver::available_isas()) {
    const Operations<T>& ops = operations<T>(isa);
    const std::size_t packs = operands.size() / ops.width;
    std::vector<std::uint32_t> bits(packs);
    const auto any = std::make_unique<bool[]>(packs);
    const auto all = std::make_unique<bool[]>(packs);
    ops.masks(operands.a.data(), operands.b.data(), bits.data(), any.get(), all.get(),
              operands.size());
    for (std::size_t pack = 0; pack < packs; ++pack) {
      std::uint32_t wanted = 0;
      for (std::size_t lane = 0; lane < ops.width; ++lane) {
        const std::size_t i = pack * ops.width + lane;
        wanted |= (operands.a[i] < operands.b[i] ? 1U : 0U) << lane;
      }
      ASSERT_EQ(bits[pack], wanted) << name(isa) << " pack " << pack;
      ASSERT_EQ(any[pack], wanted != 0) << name(isa) << " pack " << pack;
      ASSERT_EQ(all[pack], wanted == (std::uint32_t{1} << ops.width) - 1)
          << name(isa) << " pack " << pack;
    }
  }
}

TYPED_TEST(LaneOps, GatherAndScatterMoveBits) {
  using T = TypeParam;
  const std::vector<T> special = special_values<T>();
  AlignedVector<T> values(special.begin(), special.end());
  values.resize(soa::padded(values.size()), T(3));
  const std::size_t count = values.size();
  // 37 has no factor in common with the count, so this is a permutation that keeps no neighbours.
  std::vector<std::int32_t> index(count);
  for (std::size_t i = 0; i < count; ++i) index[i] = static_cast<std::int32_t>(37 * i % count);
  for (const solver::Isa isa : solver::available_isas()) {
    AlignedVector<T> gathered(count);
    AlignedVector<T> scattered(count);
    operations<T>(isa).gather(values.data(), index.data(), gathered.data(), count);
    operations<T>(isa).scatter(scattered.data(), index.data(), gathered.data(), count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto from = static_cast<std::size_t>(index[i]);
      ASSERT_EQ(bits_of(gathered[i]), bits_of(values[from])) << name(isa) << " row " << i;
      ASSERT_EQ(bits_of(scattered[i]), bits_of(values[i])) << name(isa) << " row " << i;
    }
  }
}

TYPED_TEST(LaneOps, TheLastOfEqualScatterIndicesWins) {
  using T = TypeParam;
  const std::vector<std::int32_t> index(64, 3);
  AlignedVector<T> values(64);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<T>(i);
  for (const solver::Isa isa : solver::available_isas()) {
    AlignedVector<T> base(64);
    operations<T>(isa).scatter(base.data(), index.data(), values.data(), values.size());
    EXPECT_EQ(base[3], T(63)) << name(isa);
  }
}

TEST(LaneWidths, AreThoseOfTheRegisters) {
  for (const solver::Isa isa : solver::available_isas()) {
    const std::size_t bytes = isa == solver::Isa::avx512 ? 64 : isa == solver::Isa::avx2 ? 32 : 16;
    const lane_ops::Table& table = lane_ops::table_of(isa);
    EXPECT_EQ(table.single.width, isa == solver::Isa::scalar ? 1 : bytes / 4) << name(isa);
    EXPECT_EQ(table.twice.width, isa == solver::Isa::scalar ? 1 : bytes / 8) << name(isa);
  }
}

}  // namespace salvo::tests
