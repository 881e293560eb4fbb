#include "soa/table.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace salvo::soa {

Table::Table(std::span<const Field> fields, Precision precision, const std::vector<bool>& stored)
    : fields_(fields), precision_(precision), stored_(stored), columns_(fields.size()) {
  assert(stored.size() == fields.size() && stored[0] && fields[0].scalar == Scalar::uint64);
  std::size_t number = 0;
  for (std::size_t f = 0; f < fields.size(); ++f) {
    uniform_.push_back(0);
    set_uniform(f, fields[f].fallback);
    if (!stored_[f]) continue;
    for (std::size_t c = 0; c < fields[f].components; ++c) {
      columns_[f][c] = Column(size_of(fields[f].scalar, precision), number++);
    }
  }
}

template <class Move>
void Table::for_each_column(Move&& move) {
  for (std::size_t f = 0; f < fields_.size(); ++f) {
    if (!stored_[f]) continue;
    for (std::size_t c = 0; c < fields_[f].components; ++c) move(columns_[f][c]);
  }
}

Table Table::copy() const {
  Table result(fields_, precision_, stored_);
  result.uniform_ = uniform_;
  result.append(rows_);
  for (std::size_t f = 0; f < fields_.size(); ++f) {
    if (!stored_[f] || rows_ == 0) continue;
    const std::size_t bytes = rows_ * size_of(fields_[f].scalar, precision_);
    for (std::size_t c = 0; c < fields_[f].components; ++c) {
      std::memcpy(result.bytes(f, c), this->bytes(f, c), bytes);
    }
  }
  return result;
}

void Table::reserve(std::size_t rows) {
  for_each_column([&](Column& column) { column.reserve(rows); });
}

std::size_t Table::append(std::size_t rows) {
  const std::size_t first = rows_;
  for_each_column([&](Column& column) { column.extend(first, padded(first + rows)); });
  rows_ += rows;
  return first;
}

namespace {

template <class Element>
void compact_elements(std::byte* bytes, std::span<const std::uint8_t> keep) {
  auto* data = reinterpret_cast<Element*>(bytes);
  std::size_t to = 0;
  for (std::size_t from = 0; from < keep.size(); ++from) {
    data[to] = data[from];
    to += keep[from];
  }
}

template <class Element>
void gather_elements(std::byte* bytes, std::span<const std::uint32_t> order, std::byte* scratch) {
  auto* data = reinterpret_cast<Element*>(bytes);
  auto* sorted = reinterpret_cast<Element*>(scratch);
  for (std::size_t row = 0; row < order.size(); ++row) sorted[row] = data[order[row]];
  std::copy_n(sorted, order.size(), data);
}

}  // namespace

void Table::compact(std::span<const std::uint8_t> keep) {
  assert(keep.size() == rows_);
  const auto kept = static_cast<std::size_t>(std::count(keep.begin(), keep.end(), std::uint8_t{1}));
  if (kept == rows_) return;
  for_each_column([&](Column& column) {
    if (column.element_size() == 4) {
      compact_elements<std::uint32_t>(column.data(), keep);
    } else {
      compact_elements<std::uint64_t>(column.data(), keep);
    }
    column.clear_rows(kept, padded(rows_));
  });
  rows_ = kept;
}

bool Table::sorted_by_id() const { return std::is_sorted(ids(), ids() + rows_); }

// Rows come in order but for those appended since the last time: they are sorted and merged in.
void Table::sort_by_id() {
  if (sorted_by_id()) return;
  const Id* id = ids();
  const auto by_id = [id](std::uint32_t a, std::uint32_t b) { return id[a] < id[b]; };
  std::vector<std::uint32_t> appended(rows_);
  std::iota(appended.begin(), appended.end(), 0U);
  const auto in_order = appended.begin() + (std::is_sorted_until(id, id + rows_) - id);
  std::stable_sort(in_order, appended.end(), by_id);
  std::vector<std::uint32_t> order(rows_);
  std::merge(appended.begin(), in_order, in_order, appended.end(), order.begin(), by_id);
  AlignedBytes scratch(padded(rows_) * 8);
  for_each_column([&](Column& column) {
    if (column.element_size() == 4) {
      gather_elements<std::uint32_t>(column.data(), order, scratch.data());
    } else {
      gather_elements<std::uint64_t>(column.data(), order, scratch.data());
    }
  });
}

void Table::release(std::size_t field) {
  for (Column& column : columns_[field]) column.release();
}

void Table::restore(std::size_t field) {
  if (!stored_[field]) return;
  for (std::size_t c = 0; c < fields_[field].components; ++c) columns_[field][c].restore();
}

void Table::clear_padding() {
  for_each_column([&](Column& column) { column.clear_rows(rows_, padded_rows()); });
}

std::size_t Table::resident_bytes() const {
  std::size_t bytes = 0;
  const_cast<Table*>(this)->for_each_column(
      [&](Column& column) { bytes += column.capacity_bytes(); });
  return bytes;
}

}  // namespace salvo::soa
