#include "bench/odeint_peer.hpp"

#include <boost/numeric/odeint.hpp>
#include <cmath>

namespace salvo::bench {

namespace {

namespace odeint = boost::numeric::odeint;

}  // namespace

void odeint_rk4_drag(PeerShot* shots, std::size_t count, std::int64_t steps, double dt) {
  using State = std::array<double, 6>;
  odeint::runge_kutta4<State> stepper;
  for (std::size_t i = 0; i < count; ++i) {
    const double k = shots[i].drag_factor;
    const auto rate = [k](const State& s, State& ds, double) {
      const double kv = k * std::sqrt(s[3] * s[3] + s[4] * s[4] + s[5] * s[5]);
      ds = {s[3], s[4], s[5], -kv * s[3], -kv * s[4] - 9.80665, -kv * s[5]};
    };
    odeint::integrate_n_steps(stepper, rate, shots[i].state, 0.0, dt,
                              static_cast<std::size_t>(steps));
  }
}

void odeint_lorenz(std::array<double, 3>* states, const double* rho, std::size_t count,
                   std::int64_t steps, double dt) {
  using State = std::array<double, 3>;
  for (std::size_t i = 0; i < count; ++i) {
    odeint::runge_kutta_dopri5<State> stepper;
    const double r = rho[i];
    const auto rate = [r](const State& s, State& ds, double) {
      ds = {10 * (s[1] - s[0]), s[0] * (r - s[2]) - s[1], s[0] * s[1] - 8.0 / 3 * s[2]};
    };
    odeint::integrate_n_steps(stepper, rate, states[i], 0.0, dt, static_cast<std::size_t>(steps));
  }
}

}  // namespace salvo::bench
