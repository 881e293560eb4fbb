#include "soa/table.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace salvo::soa {

Table::Table(std::span<const Field> fields, Precision precision, const std::vector<bool>& stored)
    : fields_(fields), precision_(precision), stored_(stored), columns_(fields.size()) {
  assert(stored.size() == fields.size() && stored[0] && fields[0].scalar == Scalar::uint64);
  std::size_t number = 0;
  for (std::size_t f = 0; f < fields.size(); ++f) {
    uniform_.push_back(fields[f].fallback);
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

void Table::reserve(std::size_t rows) {
  for_each_column([&](Column& column) { column.reserve(rows); });
}

std::size_t Table::append(std::size_t rows) {
  const std::size_t first = rows_;
  reserve(rows_ + rows);
  for_each_column([&](Column& column) { column.clear_rows(first, padded(first + rows)); });
  rows_ += rows;
  return first;
}

void Table::compact(std::span<const std::uint8_t> keep) {
  assert(keep.size() == rows_);
  const auto kept = static_cast<std::size_t>(std::count(keep.begin(), keep.end(), std::uint8_t{1}));
  if (kept == rows_) return;
  for_each_column([&](Column& column) {
    const std::size_t size = column.element_size();
    std::byte* data = column.data();
    std::size_t to = 0;
    for (std::size_t from = 0; from < rows_; ++from) {
      if (keep[from] == 0) continue;
      if (to != from) std::memcpy(data + to * size, data + from * size, size);
      ++to;
    }
    column.clear_rows(kept, padded(rows_));
  });
  rows_ = kept;
}

bool Table::sorted_by_id() const { return std::is_sorted(ids(), ids() + rows_); }

void Table::sort_by_id() {
  if (sorted_by_id()) return;
  std::vector<std::pair<Id, std::size_t>> order(rows_);
  for (std::size_t row = 0; row < rows_; ++row) order[row] = {ids()[row], row};
  std::sort(order.begin(), order.end());  // exact-set: ids are unique, no ties
  AlignedBytes sorted(padded(rows_) * 8);
  for_each_column([&](Column& column) {
    const std::size_t size = column.element_size();
    for (std::size_t row = 0; row < rows_; ++row) {
      std::memcpy(sorted.data() + row * size, column.data() + order[row].second * size, size);
    }
    if (rows_ != 0) std::memcpy(column.data(), sorted.data(), rows_ * size);
  });
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
