// Contact laws give the scalar lane's bits on every instruction set, and a partner feels the
// opposite force, bit for bit.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/kernels/sphere_contact_parity.hpp"
#include "tests/kernels/values.hpp"
#include "tests/per_isa.hpp"

namespace salvo::tests {

namespace sphere_contact_parity {
SALVO_TEST_TABLES
}

namespace {

using sphere_contact_parity::Quads;
using sphere_contact_parity::results;
using sphere_contact_parity::Run;

constexpr std::size_t rows = 8192;

template <class T>
using Columns = std::vector<AlignedVector<T>>;

template <class T>
Columns<T> results_of(solver::Isa isa) {
  std::mt19937_64 random(4);
  const auto within = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1p-53);
  };
  Columns<T> in(15, AlignedVector<T>(rows));
  for (std::size_t row = 0; row < rows; ++row) {
    const auto set = [&](std::size_t column, double x) { in[column][row] = static_cast<T>(x); };
    const double z = within(-1, 1);
    const double across = std::sqrt(1 - z * z);
    const double angle = within(0, 6.3);
    set(0, row % 7 == 0 ? 0 : across * std::cos(angle));
    set(1, row % 7 == 0 ? 1 : across * std::sin(angle));
    set(2, row % 7 == 0 ? 0 : z);
    for (std::size_t c = 3; c < 6; ++c) set(c, row % 11 == 0 ? 0 : within(-1, 1));
    for (std::size_t c = 6; c < 9; ++c) set(c, row % 5 == 0 ? 0 : within(-1e-5, 1e-5));
    set(9, row % 13 == 0 ? 0 : within(0, 1e-4));  // overlap
    set(10, within(1e-3, 1e-2));                  // mass
    set(11, within(1e-3, 1e-2));                  // radius
    set(12, row % 3 == 0 ? 0 : within(0, 1.2));   // damping ratio
    set(13, within(1e4, 1e6));                    // stiffness
    set(14, row % 17 == 0 ? 0 : within(0, 1));    // friction
  }
  Columns<T> out(results, AlignedVector<T>(rows));
  Run<T> run;
  run.rows = rows;
  for (std::size_t c = 0; c < 3; ++c) {
    run.normal[c] = in[c].data();
    run.velocity[c] = in[3 + c].data();
    run.displacement[c] = in[6 + c].data();
  }
  run.overlap = in[9].data();
  run.mass = in[10].data();
  run.radius = in[11].data();
  run.zeta = in[12].data();
  run.stiffness = in[13].data();
  run.friction = in[14].data();
  run.dt = static_cast<T>(1e-5);
  for (std::size_t i = 0; i < results; ++i) run.result[i] = out[i].data();
  const sphere_contact_parity::Table& table = sphere_contact_parity::table_of(isa);
  if constexpr (sizeof(T) == 4) {
    table.contact_single(run);
  } else {
    table.contact_twice(run);
  }
  return out;
}

template <class T>
class SphereContactParity : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(SphereContactParity, Reals);

TYPED_TEST(SphereContactParity, LawsGiveTheBitsOfOneLane) {
  const Columns<TypeParam> wanted = results_of<TypeParam>(solver::Isa::scalar);
  for (const solver::Isa isa : solver::available_isas()) {
    const Columns<TypeParam> got = results_of<TypeParam>(isa);
    for (std::size_t i = 0; i < results; ++i) {
      for (std::size_t row = 0; row < rows; ++row) {
        ASSERT_EQ(bits_of(got[i][row]), bits_of(wanted[i][row]))
            << name(isa) << ", result " << i << ", row " << row << ": " << got[i][row]
            << " instead of " << wanted[i][row];
      }
    }
  }
}

// Eleven results a side: force and displacement change sign, the scalars stay.
TYPED_TEST(SphereContactParity, APartnerFeelsTheOppositeForce) {
  const Columns<TypeParam> got = results_of<TypeParam>(solver::widest_isa());
  std::size_t pressed = 0;
  std::size_t slipped = 0;
  for (std::size_t law = 0; law < 2; ++law) {
    for (std::size_t i = 0; i < 11; ++i) {
      const auto& own = got[22 * law + i];
      const auto& partner = got[22 * law + 11 + i];
      for (std::size_t row = 0; row < rows; ++row) {
        // Zero has two signs: -(a - a) is -0, -a + a is +0. A sum does not tell them apart.
        const TypeParam opposite = i < 6 ? -own[row] : own[row];
        ASSERT_EQ(opposite, partner[row]) << "law " << law << ", result " << i << ", row " << row;
        if (own[row] != 0) {
          ASSERT_EQ(bits_of(opposite), bits_of(partner[row]));
        }
      }
    }
    for (std::size_t row = 0; row < rows; ++row) {
      pressed += got[22 * law + 6][row] > 0 ? 1 : 0;
      slipped += got[22 * law + 8][row] > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(pressed, rows / 2);
  EXPECT_GT(slipped, rows / 2);
}

template <class T>
void expect_moved_quads(solver::Isa isa) {
  constexpr std::size_t count = 192;
  constexpr std::size_t records = 50;
  const std::vector<T> special = special_values<T>();
  AlignedVector<T> from(16 * records);
  for (std::size_t i = 0; i < from.size(); ++i) from[i] = special[i * 7 % special.size()];
  AlignedVector<std::int32_t> index(count);
  std::mt19937_64 random(9);
  for (std::int32_t& i : index) i = static_cast<std::int32_t>(random() % records);
  AlignedVector<T> loaded(4 * count);
  AlignedVector<T> stored(16 * count, T(77));
  const Quads<T> run{count, from.data(), index.data(), loaded.data(), stored.data()};
  const sphere_contact_parity::Table& table = sphere_contact_parity::table_of(isa);
  if constexpr (sizeof(T) == 4) {
    table.quads_single(run);
  } else {
    table.quads_twice(run);
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < 16; ++k) {
      // The third quad is the second one of the record; nothing else is touched.
      const auto record = static_cast<std::size_t>(index[i]);
      const bool quad = k >= 8 && k < 12;
      const T wanted = quad ? from[16 * record + k - 4] : T(77);
      ASSERT_EQ(bits_of(stored[16 * i + k]), bits_of(wanted)) << name(isa) << i << ' ' << k;
      if (quad) {
        ASSERT_EQ(bits_of(loaded[(k - 8) * count + i]), bits_of(wanted)) << name(isa);
      }
    }
  }
}

TYPED_TEST(SphereContactParity, QuadsOnlyMoveBits) {
  for (const solver::Isa isa : solver::available_isas()) expect_moved_quads<TypeParam>(isa);
}

}  // namespace
}  // namespace salvo::tests
