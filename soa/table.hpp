// The columns of one kind of thing: rows of a list of fields. A field that has the same value in
// every row of a scene is not stored: the table keeps that one value.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <span>
#include <vector>

#include "soa/column.hpp"
#include "soa/field.hpp"
#include "soa/id.hpp"

namespace salvo::soa {

class Table {
 public:
  /// Fields with stored[i] false hold `uniform(i)` in every row. Field 0 is the id and is always
  /// stored.
  Table(std::span<const Field> fields, Precision precision, const std::vector<bool>& stored);

  /// The same fields and rows.
  Table copy() const;

  std::span<const Field> fields() const { return fields_; }
  Precision precision() const { return precision_; }
  std::size_t rows() const { return rows_; }
  std::size_t padded_rows() const { return padded(rows_); }
  bool stored(std::size_t field) const { return stored_[field]; }
  double uniform(std::size_t field) const { return uniform_[field]; }
  /// The value as a row would hold it: rounded to the table's precision.
  void set_uniform(std::size_t field, double value) {
    const bool narrow = fields_[field].scalar == Scalar::real && precision_ == Precision::float32;
    uniform_[field] = narrow ? static_cast<double>(static_cast<float>(value)) : value;
  }

  /// The column of a stored field's component; nullptr when the field is uniform or released. T
  /// must match the field's scalar.
  template <class T>
  T* column(std::size_t field, std::size_t component = 0) {
    assert(sizeof(T) == size_of(fields_[field].scalar, precision_));
    return stored_[field] ? reinterpret_cast<T*>(columns_[field][component].data()) : nullptr;
  }
  template <class T>
  const T* column(std::size_t field, std::size_t component = 0) const {
    return const_cast<Table*>(this)->column<T>(field, component);
  }
  std::byte* bytes(std::size_t field, std::size_t component) {
    return columns_[field][component].data();
  }
  const std::byte* bytes(std::size_t field, std::size_t component) const {
    return columns_[field][component].data();
  }
  Id* ids() { return column<Id>(0); }
  const Id* ids() const { return column<Id>(0); }

  void reserve(std::size_t rows);
  /// Adds rows filled with zero at the end; returns the index of the first.
  std::size_t append(std::size_t rows);
  /// Keeps the rows whose `keep` is 1, in their order. `keep` has one entry a row.
  void compact(std::span<const std::uint8_t> keep);
  /// Orders the rows by ascending id; no work when they are.
  void sort_by_id();
  bool sorted_by_id() const;
  /// Gives back the storage of a field, with what is in it. Until restore() nothing else is called
  /// that reads, moves or adds rows.
  void release(std::size_t field);
  /// Zero in every row, where it was released.
  void restore(std::size_t field);
  /// Zeroes the padding rows after the last row.
  void clear_padding();
  /// Bytes held, padding included.
  std::size_t resident_bytes() const;

 private:
  template <class Move>
  void for_each_column(Move&& move);

  std::span<const Field> fields_;
  Precision precision_;
  std::vector<bool> stored_;
  std::vector<double> uniform_;
  std::vector<std::array<Column, 3>> columns_;
  std::size_t rows_ = 0;
};

}  // namespace salvo::soa
