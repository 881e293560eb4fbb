#include "recording/selection.hpp"

#include <algorithm>
#include <cstring>

namespace salvo::recording {

namespace {

constexpr std::size_t leaf_rows = 4096;

Rows description_of(const soa::Table& table) {
  Rows rows;
  for (std::size_t f = 0; f < table.fields().size(); ++f) {
    rows.stored.push_back(table.stored(f));
    rows.uniform.push_back(table.uniform(f));
  }
  return rows;
}

// Which rows of a leaf the selection keeps, from its first on.
class KeptRows {
 public:
  KeptRows(const soa::Id* ids, std::size_t count, const Selection& selection) {
    for (std::size_t row = 0; row < count; ++row) {
      rows_[count_] = static_cast<std::uint16_t>(row);
      count_ += selection.keeps(ids[row]) ? 1 : 0;
    }
  }
  std::size_t count() const { return count_; }

  /// `from` is the first row's element.
  template <class Element>
  void copy(const std::byte* from, std::byte* to) const {
    for (std::size_t i = 0; i < count_; ++i) {
      std::memcpy(to + i * sizeof(Element), from + rows_[i] * sizeof(Element), sizeof(Element));
    }
  }

 private:
  std::array<std::uint16_t, leaf_rows> rows_;
  std::size_t count_ = 0;
};

}  // namespace

Rows all_rows(const soa::Table& table) {
  Rows rows = description_of(table);
  rows.count = table.rows();
  rows.complete = true;
  for (std::size_t f = 0; f < table.fields().size(); ++f) {
    if (!table.stored(f)) continue;
    FieldRows& field = rows.fields.emplace_back();
    field.field = f;
    for (std::size_t c = 0; c < table.fields()[f].components; ++c) {
      field.components[c] = table.bytes(f, c);
    }
  }
  return rows;
}

void RowBuffer::copy(const soa::Table& table, std::span<const std::size_t> fields,
                     const Selection& selection, const solver::Parallel& parallel) {
  const std::size_t leaves = (table.rows() + leaf_rows - 1) / leaf_rows;
  const auto rows_of = [&](std::size_t leaf) {
    return std::min(leaf_rows, table.rows() - leaf * leaf_rows);
  };
  const auto kept_of = [&](std::size_t leaf) {
    return KeptRows(table.ids() + leaf * leaf_rows, rows_of(leaf), selection);
  };

  first_row_.assign(leaves + 1, 0);
  parallel.for_each(leaves, [&](std::size_t leaf) {
    first_row_[leaf + 1] = selection.all() ? rows_of(leaf) : kept_of(leaf).count();
  });
  for (std::size_t leaf = 0; leaf < leaves; ++leaf) first_row_[leaf + 1] += first_row_[leaf];

  rows_ = description_of(table);
  rows_.count = first_row_[leaves];
  rows_.complete = selection.all();
  for (std::size_t f = 0; f < table.fields().size(); ++f) {
    const bool taken = std::find(fields.begin(), fields.end(), f) != fields.end();
    if (table.stored(f) && !taken) rows_.complete = false;
  }
  columns_.resize(fields.size());
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const soa::Field& field = table.fields()[fields[i]];
    FieldRows& rows = rows_.fields.emplace_back();
    rows.field = fields[i];
    if (!table.stored(fields[i])) continue;
    for (std::size_t c = 0; c < field.components; ++c) {
      const std::size_t bytes = rows_.count * size_of(field.scalar, table.precision());
      if (columns_[i][c].size() < bytes) columns_[i][c] = soa::AlignedBytes(bytes);
      rows.components[c] = columns_[i][c].data();
    }
  }

  const auto copy_leaf = [&](std::size_t leaf, auto copy) {
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const soa::Field& field = table.fields()[fields[i]];
      if (!table.stored(fields[i])) continue;
      const std::size_t size = size_of(field.scalar, table.precision());
      for (std::size_t c = 0; c < field.components; ++c) {
        copy(table.bytes(fields[i], c) + leaf * leaf_rows * size,
             columns_[i][c].data() + first_row_[leaf] * size, size);
      }
    }
  };
  parallel.for_each(leaves, [&](std::size_t leaf) {
    if (selection.all()) {
      copy_leaf(leaf, [&](const std::byte* from, std::byte* to, std::size_t size) {
        std::memcpy(to, from, rows_of(leaf) * size);
      });
      return;
    }
    const KeptRows kept = kept_of(leaf);
    copy_leaf(leaf, [&](const std::byte* from, std::byte* to, std::size_t size) {
      size == 4 ? kept.copy<std::uint32_t>(from, to) : kept.copy<std::uint64_t>(from, to);
    });
  });
}

std::size_t RowBuffer::capacity_bytes() const {
  std::size_t bytes = 0;
  for (const auto& components : columns_) {
    for (const soa::AlignedBytes& column : components) bytes += column.size();
  }
  return bytes;
}

}  // namespace salvo::recording
