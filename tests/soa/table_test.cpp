// The table against the plainest model of one, a vector of rows, over random sequences of
// operations; and what the kernels rely on: alignment, padding of zeros, uniform fields, bytes.
#include "soa/table.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "soa/particle_fields.hpp"

namespace salvo::tests {

namespace {

using soa::Precision;
using soa::Scalar;
using soa::Table;

constexpr std::array<soa::Field, 5> fields{{
    {"id", Scalar::uint64, 1, "", "", 0, 0, 1},
    {"place", Scalar::real, 3, "m", "", 0, 0, 1},
    {"weight", Scalar::real, 1, "kg", "", 2.5, 0, 1},
    {"step", Scalar::int32, 1, "", "", 7, 0, 1},
    {"label", Scalar::uint32, 1, "", "", 3, 0, 1},
}};
const std::vector<bool> all_stored(fields.size(), true);

struct Row {
  soa::Id id;
  std::array<double, 3> place;
  double weight;
  std::int32_t step;
  std::uint32_t label;

  friend bool operator==(const Row&, const Row&) = default;
};

// Every value of a row follows from its id, in numbers that float holds.
Row row_of(soa::Id id) {
  const auto x = static_cast<double>(id % 8191);
  return {id,
          {x + 0.25, -x, 3 * x},
          x / 2,
          static_cast<std::int32_t>(id % 99) - 50,
          static_cast<std::uint32_t>(id % 13)};
}

template <class T>
void write(Table& table, std::size_t at, const Row& row) {
  table.ids()[at] = row.id;
  for (std::size_t c = 0; c < 3; ++c) table.column<T>(1, c)[at] = static_cast<T>(row.place[c]);
  table.column<T>(2)[at] = static_cast<T>(row.weight);
  table.column<std::int32_t>(3)[at] = row.step;
  table.column<std::uint32_t>(4)[at] = row.label;
}

template <class T>
Row read(const Table& table, std::size_t at) {
  Row row{};
  row.id = table.ids()[at];
  for (std::size_t c = 0; c < 3; ++c) {
    row.place[c] = static_cast<double>(table.column<T>(1, c)[at]);
  }
  row.weight = static_cast<double>(table.column<T>(2)[at]);
  row.step = table.column<std::int32_t>(3)[at];
  row.label = table.column<std::uint32_t>(4)[at];
  return row;
}

template <class T>
std::vector<Row> read_all(const Table& table) {
  std::vector<Row> rows;
  for (std::size_t at = 0; at < table.rows(); ++at) rows.push_back(read<T>(table, at));
  return rows;
}

template <class T>
constexpr Precision precision_of = sizeof(T) == 4 ? Precision::float32 : Precision::float64;

// The padding rows are zero in every column.
template <class T>
bool padding_is_zero(const Table& table) {
  for (std::size_t at = table.rows(); at < table.padded_rows(); ++at) {
    if (!(read<T>(table, at) == Row{})) return false;
  }
  return true;
}

// What a kernel may leave behind.
template <class T>
void soil_padding(Table& table) {
  for (std::size_t at = table.rows(); at < table.padded_rows(); ++at) {
    write<T>(table, at, row_of(33));
  }
}

template <class T>
void append(Table& table, std::vector<Row>& model, std::size_t count, soa::Id& next) {
  if (count != 0) soil_padding<T>(table);
  const std::size_t first = table.append(count);
  RC_ASSERT(first == model.size());
  for (std::size_t i = 0; i < count; ++i) {
    RC_ASSERT(read<T>(table, first + i) == Row{});  // new rows are zero, used before or not
    // Ids in no order, each once: multiplication by an odd number permutes 20 bits.
    model.push_back(row_of(next++ * 0x9E375 % (1U << 20)));
    write<T>(table, first + i, model.back());
  }
}

template <class T>
void matches_model_over_any_operations() {
  Table table(fields, precision_of<T>, all_stored);
  std::vector<Row> model;
  soa::Id next = 1;
  const auto operations = *rc::gen::inRange(1, 25);
  for (int k = 0; k < operations; ++k) {
    switch (*rc::gen::inRange(0, 5)) {
      case 0:
        append<T>(table, model, *rc::gen::inRange<std::size_t>(0, 200), next);
        break;
      case 1: {
        const auto keep = *rc::gen::container<std::vector<std::uint8_t>>(
            model.size(), rc::gen::inRange<std::uint8_t>(0, 2));
        if (std::count(keep.begin(), keep.end(), std::uint8_t{0}) != 0) soil_padding<T>(table);
        table.compact(keep);
        std::vector<Row> kept;
        for (std::size_t i = 0; i < model.size(); ++i) {
          if (keep[i] != 0) kept.push_back(model[i]);
        }
        model = kept;
        break;
      }
      case 2:
        table.sort_by_id();
        std::sort(model.begin(), model.end(),
                  [](const Row& a, const Row& b) { return a.id < b.id; });
        RC_ASSERT(table.sorted_by_id());
        break;
      case 3:
        table.reserve(*rc::gen::inRange<std::size_t>(0, 500));
        break;
      case 4:
        soil_padding<T>(table);
        table.clear_padding();
        break;
    }
    RC_ASSERT(read_all<T>(table) == model);
    RC_ASSERT(padding_is_zero<T>(table));
  }
}

}  // namespace

RC_GTEST_PROP(Table, FloatMatchesAVectorOfRows, ()) { matches_model_over_any_operations<float>(); }
RC_GTEST_PROP(Table, DoubleMatchesAVectorOfRows, ()) {
  matches_model_over_any_operations<double>();
}

TEST(Table, ColumnsAreAlignedAndPaddedToWholeBlocks) {
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    Table table(fields, precision, all_stored);
    for (const std::size_t rows : {1, 2, 64, 61, 4097}) {
      table.append(rows);
      EXPECT_EQ(table.padded_rows() % 64, 0U);
      EXPECT_GE(table.padded_rows(), table.rows());
      EXPECT_LT(table.padded_rows(), table.rows() + 64);
      for (std::size_t f = 0; f < fields.size(); ++f) {
        for (std::size_t c = 0; c < fields[f].components; ++c) {
          EXPECT_EQ(reinterpret_cast<std::uintptr_t>(table.bytes(f, c)) % 64, 0U);
        }
      }
    }
  }
}

TEST(Table, UniformFieldsTakeNoBytesAndKeepOneValue) {
  Table table(fields, Precision::float32, {true, true, false, false, true});
  EXPECT_EQ(table.uniform(2), 2.5);  // the field's fallback until somebody sets it
  table.set_uniform(2, 0.1);
  EXPECT_EQ(table.uniform(2), static_cast<double>(0.1F));  // as a row would hold it
  table.set_uniform(2, 0.125);
  table.append(65);
  EXPECT_FALSE(table.stored(2));
  EXPECT_TRUE(table.stored(4));
  EXPECT_EQ(table.column<float>(2), nullptr);
  EXPECT_EQ(table.column<std::int32_t>(3), nullptr);
  EXPECT_EQ(table.uniform(2), 0.125);
  EXPECT_EQ(table.resident_bytes(), 128U * (8 + 3 * 4 + 4));
}

TEST(Table, CountsTheBytesOfItsColumns) {
  Table single(soa::particle_fields, Precision::float32,
               std::vector<bool>(soa::particle_fields.size(), true));
  Table twice(soa::particle_fields, Precision::float64,
              std::vector<bool>(soa::particle_fields.size(), true));
  EXPECT_EQ(single.resident_bytes(), 0U);
  single.reserve(4097);
  twice.reserve(4097);
  EXPECT_EQ(single.resident_bytes(), 4160U * (8 + 20 * 4 + 3 * 4));
  EXPECT_EQ(twice.resident_bytes(), 4160U * (8 + 20 * 8 + 3 * 4));
  single.append(4097);
  EXPECT_EQ(single.resident_bytes(), 4160U * (8 + 20 * 4 + 3 * 4));  // reserved is enough
}

TEST(Table, GivesBackTheStorageOfAFieldAndTakesItAgain) {
  Table table(fields, Precision::float32, {true, true, false, true, true});
  table.reserve(300);
  const std::size_t bytes = table.resident_bytes();
  table.append(65);
  for (std::size_t row = 0; row < 65; ++row) {
    table.ids()[row] = row;
    table.column<float>(1, 2)[row] = 7;
    table.column<std::int32_t>(3)[row] = 8;
  }
  for (const std::size_t field : {1U, 2U}) table.release(field);  // 2 has none
  EXPECT_EQ(table.column<float>(1, 2), nullptr);
  EXPECT_EQ(table.resident_bytes(), bytes - 320U * 3 * 4);
  for (const std::size_t field : {1U, 1U, 2U}) table.restore(field);
  EXPECT_EQ(table.resident_bytes(), bytes);  // what was reserved, too
  for (std::size_t row = 0; row < 65; ++row) {
    EXPECT_EQ(table.ids()[row], row);
    EXPECT_EQ(table.column<float>(1, 2)[row], 0);
    EXPECT_EQ(table.column<std::int32_t>(3)[row], 8);
  }
}

TEST(Table, KeepsColumnsWhereTheyAreWithinTheReserve) {
  Table table(fields, Precision::float64, all_stored);
  table.reserve(300);
  const std::byte* before = table.bytes(1, 2);
  for (int i = 0; i < 3; ++i) table.append(99);
  EXPECT_EQ(table.bytes(1, 2), before);
}

TEST(Table, OfNoRowsSortsAndCompacts) {
  Table table(fields, Precision::float32, all_stored);
  table.sort_by_id();
  table.compact({});
  table.clear_padding();
  EXPECT_EQ(table.append(0), 0U);
  EXPECT_EQ(table.rows(), 0U);
  EXPECT_EQ(table.padded_rows(), 0U);
  EXPECT_TRUE(table.sorted_by_id());
}

TEST(Ids, HoldStreamAndSerial) {
  const soa::Id id = soa::make_id(soa::max_stream, soa::max_serial - 3);
  EXPECT_EQ(soa::stream_of(id), soa::max_stream);
  EXPECT_EQ(soa::serial_of(id), soa::max_serial - 3);
  EXPECT_EQ(soa::make_id(soa::max_stream, soa::max_serial), ~soa::Id{0});
  EXPECT_LT(soa::make_id(3, soa::max_serial), soa::make_id(4, 0));  // streams sort before serials
}

}  // namespace salvo::tests
