// A user's own model: the plane pendulum, theta'' = -(g / l) sin theta.
#pragma once

#include <salvo/kernels/math.hpp>
#include <salvo/soa/field.hpp>
#include <salvo/solver/batch_kernel.hpp>

#include <array>

template <class V>
struct Pendulum {
  using Field = salvo::soa::Field;
  static constexpr std::array<Field, 2> state_fields{{
      {"angle", salvo::soa::Scalar::real, 1, "rad", "from the vertical", 0, -1e9, 1e9},
      {"rate", salvo::soa::Scalar::real, 1, "rad/s", "of the angle", 0, -1e9, 1e9},
  }};
  static constexpr std::array<Field, 1> parameter_fields{{
      {"length", salvo::soa::Scalar::real, 1, "m", "of the rod", 1, 1e-6, 1e6},
  }};

  std::array<V, 2> rate(V, const std::array<V, 2>& s, const std::array<V, 1>& p) const {
    return {s[1], V(-9.80665) / p[0] * sin(s[0])};
  }
};

SALVO_DECLARE_MODEL(pendulum)
