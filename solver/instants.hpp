// The coefficients of the forces that depend on time alone, for the instants of a pass: a function
// of the integer step.
#pragma once

#include <cstdint>
#include <vector>

#include "models/force_settings.hpp"

namespace salvo::solver {

/// Fills in what the user left to be derived: gust direction and speed from the mean wind, unit
/// vectors.
models::ForceSettings completed(models::ForceSettings forces);

/// Coefficients for t_n, t_n + dt/2, .., t_n + steps dt, n = first_step: 2 steps + 1 entries of
/// models::instant_coefficients(blasts). `forces` must be completed.
template <class T>
void instant_coefficients(const models::ForceSettings& forces, std::uint64_t seed, double t0,
                          double dt, std::int64_t first_step, std::int32_t steps,
                          std::vector<T>& coefficients);

}  // namespace salvo::solver
