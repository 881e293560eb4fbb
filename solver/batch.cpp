#include "solver/batch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace salvo::solver {

namespace {

constexpr std::size_t tile_rows = 4096;

std::vector<soa::Field> fields_of(const BatchKernels& kernels) {
  std::vector<soa::Field> fields;
  fields.push_back({"id", soa::Scalar::uint64, 1, "", "row of the batch", 0, 0, 0});
  fields.insert(fields.end(), kernels.state_fields.begin(), kernels.state_fields.end());
  fields.insert(fields.end(), kernels.parameter_fields.begin(), kernels.parameter_fields.end());
  return fields;
}

void call(const BatchKernels& kernels, const BatchPass<float>& pass) {
  kernels.advance_single(pass);
}
void call(const BatchKernels& kernels, const BatchPass<double>& pass) {
  kernels.advance_twice(pass);
}

}  // namespace

Batch::Batch(BatchModel model, soa::Precision precision, std::size_t rows, double t0)
    : model_(model),
      fields_(fields_of(model(Isa::scalar))),
      table_(fields_, precision, std::vector<bool>(fields_.size(), true)),
      t0_(t0) {
  table_.append(rows);
  for (std::size_t row = 0; row < rows; ++row) table_.ids()[row] = row;
  for (std::size_t f = 1; f < fields_.size(); ++f) {
    const double value = fields_[f].fallback;
    if (precision == soa::Precision::single) {
      std::fill_n(table_.column<float>(f), rows, static_cast<float>(value));
    } else {
      std::fill_n(table_.column<double>(f), rows, value);
    }
  }
}

std::size_t Batch::field_index(std::string_view name) const {
  for (std::size_t f = 1; f < fields_.size(); ++f) {
    if (fields_[f].name == name) return f;
  }
  throw std::invalid_argument(fmt::format("the model has no field \"{}\"", name));
}

template <class T>
void Batch::advance_rows(const BatchKernels& kernels, std::int64_t steps, double dt, int threads) {
  std::vector<T*> state;
  std::vector<const T*> parameters;
  for (std::size_t f = 1; f < fields_.size(); ++f) {
    T* column = table_.column<T>(f);
    if (f <= kernels.state_fields.size()) {
      state.push_back(column);
    } else {
      parameters.push_back(column);
    }
  }
  const std::size_t tiles = (rows() + tile_rows - 1) / tile_rows;
  Parallel(threads).for_each(tiles, [&](std::size_t tile) {
    BatchPass<T> pass;
    pass.first_row = tile * tile_rows;
    pass.last_row = std::min(rows(), pass.first_row + tile_rows);
    pass.state = state.data();
    pass.parameters = parameters.data();
    pass.t0 = t0_;
    pass.dt = dt;
    pass.first_step = step_;
    pass.steps = steps;
    call(kernels, pass);
  });
}

void Batch::advance(std::int64_t steps, double dt, Isa isa, int threads) {
  const BatchKernels& kernels = model_(isa);
  if (table_.precision() == soa::Precision::single) {
    advance_rows<float>(kernels, steps, dt, threads);
  } else {
    advance_rows<double>(kernels, steps, dt, threads);
  }
  table_.clear_padding();
  step_ += steps;
}

StateHash Batch::hash() const { return state_hash(table_, Parallel(1)); }

}  // namespace salvo::solver
