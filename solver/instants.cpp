#include "solver/instants.hpp"

#include "kernels/random.hpp"
#include "models/particle.hpp"
#include "soa/id.hpp"

namespace salvo::solver {

namespace {

using S = kernels::ScalarLane<double>;

double length(const models::Triple& v) {
  return sqrt(S(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])).value();
}

models::Triple unit_or(const models::Triple& v, const models::Triple& otherwise) {
  const double l = length(v);
  if (!(l > 0)) return otherwise;
  return {v[0] / l, v[1] / l, v[2] / l};
}

// Phases belong to the last stream, which no emitter may take.
double phase(std::uint64_t seed, std::size_t axis, std::size_t term) {
  const kernels::Draws draws(seed, soa::make_id(soa::max_stream, axis * 8 + term));
  return 2 * kernels::pi * draws.uniform(0);
}

// sin(m k (x - U t) + phase) = A cos(m k x) + B sin(m k x), each term with amplitude sigma/2: eight
// of them have the variance sigma^2.
template <class T>
void gust(const models::Gust& gust, std::uint64_t seed, double time, T* out) {
  const double k = 2 * kernels::pi / gust.length;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double amplitude = gust.standard_deviation[axis] / 2;
    for (std::size_t m = 0; m < kernels::gust_terms; ++m) {
      const S angle(phase(seed, axis, m) - static_cast<double>(m + 1) * k * gust.speed * time);
      out[axis * 16 + m] = static_cast<T>(amplitude * sin(angle).value());
      out[axis * 16 + 8 + m] = static_cast<T>(amplitude * cos(angle).value());
    }
  }
}

double blast_amplitude(const models::Blast& blast, double time, double dt) {
  const double since = time - blast.time;
  if (since < -1e-9 * dt) return 0;
  return blast.impulse / blast.duration * exp(S(-since / blast.duration)).value();
}

}  // namespace

models::ForceSettings completed(models::ForceSettings forces) {
  forces.up = unit_or(forces.up, {0, 1, 0});
  if (forces.gusty) {
    const models::Triple along = forces.windy ? forces.wind.velocity : models::Triple{};
    forces.gust.direction = unit_or(forces.gust.direction, unit_or(along, {1, 0, 0}));
    if (forces.gust.speed == 0) forces.gust.speed = length(along);
  }
  return forces;
}

template <class T>
void instant_coefficients(const models::ForceSettings& forces, std::uint64_t seed, double t0,
                          double dt, std::int64_t first_step, std::int32_t steps,
                          std::vector<T>& coefficients) {
  const std::size_t stride = models::instant_coefficients(forces.blasts.size());
  const std::size_t instants = 2 * static_cast<std::size_t>(steps) + 1;
  coefficients.assign(instants * stride, T(0));
  if (!forces.gusty && forces.blasts.empty()) return;
  for (std::size_t i = 0; i < instants; ++i) {
    // Half steps are exact in double, so an instant's time does not depend on the pass that it is
    // in.
    const double time = t0 + (static_cast<double>(first_step) + 0.5 * static_cast<double>(i)) * dt;
    T* out = coefficients.data() + i * stride;
    if (forces.gusty) gust(forces.gust, seed, time, out);
    for (std::size_t b = 0; b < forces.blasts.size(); ++b) {
      out[models::gust_coefficients + b] =
          static_cast<T>(blast_amplitude(forces.blasts[b], time, dt));
    }
  }
}

template void instant_coefficients(const models::ForceSettings&, std::uint64_t, double, double,
                                   std::int64_t, std::int32_t, std::vector<float>&);
template void instant_coefficients(const models::ForceSettings&, std::uint64_t, double, double,
                                   std::int64_t, std::int32_t, std::vector<double>&);

}  // namespace salvo::solver
