// Turns a model into kernels. A model is a class template over the lane type:
//
//   template <class V>
//   struct Pendulum {
//     static constexpr std::array<salvo::soa::Field, 2> state_fields{{ .. angle .. rate .. }};
//     static constexpr std::array<salvo::soa::Field, 1> parameter_fields{{ .. length .. }};
//     std::array<V, 2> rate(V t, const std::array<V, 2>& s, const std::array<V, 1>& p) const;
//   };
//
// In one source, given to salvo_add_kernels:      SALVO_DEFINE_MODEL(pendulum, Pendulum)
// In a header for the rest of the program:        SALVO_DECLARE_MODEL(pendulum)
// which declares `const BatchKernels& pendulum_kernels(Isa)`, for salvo::solver::Batch.
#pragma once

#include <algorithm>
#include <array>
#include <stdexcept>

#include "integrators/runge_kutta.hpp"
#include "soa/column.hpp"
#include "solver/batch.hpp"
#include "solver/lane_refill.hpp"

namespace salvo::solver {
inline namespace SALVO_ISA {

/// Batches hold one real number a field.
constexpr bool scalar_fields(const auto& fields) {
  for (const soa::Field& field : fields) {
    if (field.components != 1 || field.scalar != soa::Scalar::real) return false;
  }
  return true;
}

template <template <class> class Model, class T>
void advance_batch(const BatchPass<T>& pass) {
  using V = kernels::NativeLane<T>;
  using M = Model<V>;
  constexpr std::size_t states = M::state_fields.size();
  constexpr std::size_t parameters = M::parameter_fields.size();
  static_assert(scalar_fields(M::state_fields) && scalar_fields(M::parameter_fields));
  const M model = make_model<M>(pass.data);
  const V dt(pass.dt);
  for (std::size_t row = pass.first_row; row < soa::padded(pass.last_row); row += V::width) {
    std::array<V, states> s;
    std::array<V, parameters> p;
    for (std::size_t i = 0; i < states; ++i) s[i] = V::load(pass.state[i] + row);
    for (std::size_t i = 0; i < parameters; ++i) p[i] = V::load(pass.parameters[i] + row);
    for (std::int64_t k = 0; k < pass.steps; ++k) {
      const V t(pass.t0 + static_cast<double>(pass.first_step + k) * pass.dt);
      s = integrators::runge_kutta_4(
          s, t, dt, [&](V at, const std::array<V, states>& y) { return model.rate(at, y, p); });
    }
    for (std::size_t i = 0; i < states; ++i) s[i].store(pass.state[i] + row);
  }
}

template <class M>
bool accepts_data(const models::ModelData& data) {
  if constexpr (requires { typename M::Data; }) {
    return dynamic_cast<const typename M::Data*>(&data) != nullptr;
  } else {
    return false;
  }
}

/// A model's inputs; without `input_fields` they are the state, then the parameters.
template <class M>
constexpr auto input_fields_of() {
  if constexpr (requires { M::input_fields; }) {
    return M::input_fields;
  } else {
    constexpr std::size_t states = M::state_fields.size();
    std::array<soa::Field, states + M::parameter_fields.size()> fields{};
    for (std::size_t i = 0; i < fields.size(); ++i) {
      fields[i] = i < states ? M::state_fields[i] : M::parameter_fields[i - states];
    }
    return fields;
  }
}
template <class M>
inline constexpr auto input_fields = input_fields_of<M>();

template <class M>
inline constexpr std::span<const soa::Field> result_fields = [] {
  if constexpr (requires { M::result_fields; }) {
    return std::span<const soa::Field>(M::result_fields);
  } else {
    return std::span<const soa::Field>();
  }
}();

/// out = function(in), a pack of rows at a time; lanes without a row repeat the last one.
template <std::size_t in_fields, std::size_t out_fields, class Function>
void map_columns(const ColumnPass& pass, const Function& function) {
  using V = kernels::NativeLane<double>;
  for (std::size_t first = 0; first < pass.rows; first += V::width) {
    alignas(soa::alignment) double values[V::width];
    const auto in = kernels::array_of<in_fields>([&](std::size_t f) {
      for (std::size_t lane = 0; lane < V::width; ++lane) {
        values[lane] = pass.in[f][std::min(first + lane, pass.rows - 1)];
      }
      return V::load(values);
    });
    const std::array<V, out_fields> out = function(in);
    for (std::size_t f = 0; f < out_fields; ++f) {
      out[f].store(values);
      for (std::size_t lane = 0; lane < V::width && first + lane < pass.rows; ++lane) {
        pass.out[f][first + lane] = values[lane];
      }
    }
  }
}

template <template <class> class Model>
void start_rows(const ColumnPass& pass) {
  using M = Model<kernels::NativeLane<double>>;
  constexpr std::size_t inputs = input_fields<M>.size();
  constexpr std::size_t started = M::state_fields.size() + M::parameter_fields.size();
  const M model{};
  map_columns<inputs, started>(pass, [&](const auto& in) {
    if constexpr (requires { M::input_fields; }) {
      return model.start(in);
    } else {
      return in;
    }
  });
}

template <template <class> class Model>
void finish_rows(const ColumnPass& pass) {
  using V = kernels::NativeLane<double>;
  using M = Model<V>;
  if constexpr (requires { M::result_fields; }) {
    constexpr std::size_t inputs = input_fields<M>.size();
    constexpr std::size_t states = M::state_fields.size();
    const M model{};
    map_columns<inputs + 1 + states, M::result_fields.size()>(pass, [&](const auto& columns) {
      return model.results(
          kernels::array_of<inputs>([&](std::size_t i) { return columns[i]; }), columns[inputs],
          kernels::array_of<states>([&](std::size_t i) { return columns[inputs + 1 + i]; }));
    });
  }
}

}  // namespace SALVO_ISA
}  // namespace salvo::solver

// NOLINTBEGIN(bugprone-macro-parentheses): a template has none.
#define SALVO_JOIN_2(A, B) A##_##B
#define SALVO_JOIN(A, B) SALVO_JOIN_2(A, B)

#define SALVO_DEFINE_MODEL(NAME, MODEL)                                        \
  namespace salvo_models {                                                     \
  extern const salvo::solver::BatchKernels SALVO_JOIN(NAME, SALVO_ISA);        \
  const salvo::solver::BatchKernels SALVO_JOIN(NAME, SALVO_ISA){               \
      MODEL<salvo::kernels::NativeLane<float>>::state_fields,                  \
      MODEL<salvo::kernels::NativeLane<float>>::parameter_fields,              \
      salvo::solver::input_fields<MODEL<salvo::kernels::NativeLane<double>>>,  \
      salvo::solver::result_fields<MODEL<salvo::kernels::NativeLane<double>>>, \
      salvo::solver::events_of<MODEL<salvo::kernels::NativeLane<float>>>,      \
      salvo::solver::of_positions<MODEL<salvo::kernels::NativeLane<float>>>(), \
      &salvo::solver::advance_batch<MODEL, float>,                             \
      &salvo::solver::advance_batch<MODEL, double>,                            \
      &salvo::solver::integrate_batch<MODEL, float>,                           \
      &salvo::solver::integrate_batch<MODEL, double>,                          \
      &salvo::solver::start_rows<MODEL>,                                       \
      &salvo::solver::finish_rows<MODEL>,                                      \
      &salvo::solver::accepts_data<MODEL<salvo::kernels::NativeLane<float>>>}; \
  }

// NOLINTEND(bugprone-macro-parentheses)

#if defined(__aarch64__)
#define SALVO_DECLARE_MODEL_WIDE(NAME) extern const salvo::solver::BatchKernels NAME##_neon;
#define SALVO_MODEL_CASES(NAME)  \
  case salvo::solver::Isa::neon: \
    return salvo_models::NAME##_neon;
#else
#ifdef SALVO_NO_AVX512
#define SALVO_DECLARE_MODEL_512(NAME)
#define SALVO_MODEL_CASE_512(NAME)
#else
#define SALVO_DECLARE_MODEL_512(NAME) extern const salvo::solver::BatchKernels NAME##_avx512;
#define SALVO_MODEL_CASE_512(NAME) \
  case salvo::solver::Isa::avx512: \
    return salvo_models::NAME##_avx512;
#endif
#define SALVO_DECLARE_MODEL_WIDE(NAME)                  \
  extern const salvo::solver::BatchKernels NAME##_sse2; \
  extern const salvo::solver::BatchKernels NAME##_avx2; \
  SALVO_DECLARE_MODEL_512(NAME)
#define SALVO_MODEL_CASES(NAME)       \
  case salvo::solver::Isa::sse2:      \
    return salvo_models::NAME##_sse2; \
  case salvo::solver::Isa::avx2:      \
    return salvo_models::NAME##_avx2; \
    SALVO_MODEL_CASE_512(NAME)
#endif

#define SALVO_DECLARE_MODEL(NAME)                                                      \
  namespace salvo_models {                                                             \
  extern const salvo::solver::BatchKernels NAME##_scalar;                              \
  SALVO_DECLARE_MODEL_WIDE(NAME)                                                       \
  }                                                                                    \
  inline const salvo::solver::BatchKernels& NAME##_kernels(salvo::solver::Isa isa) {   \
    switch (isa) {                                                                     \
      case salvo::solver::Isa::scalar:                                                 \
        return salvo_models::NAME##_scalar;                                            \
        SALVO_MODEL_CASES(NAME)                                                        \
      default:                                                                         \
        break;                                                                         \
    }                                                                                  \
    throw std::invalid_argument("this build has no kernels for this instruction set"); \
  }
