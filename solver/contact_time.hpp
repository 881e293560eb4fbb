// How long a contact lasts, and the time step that follows it.
//
//   linear   t = pi sqrt(m*/k) without damping: see kernels::impact_duration. A step is t/50.
//   Hertz    An impact takes longer the slower it is. The wave that crosses the smallest sphere
//            takes the Rayleigh time, pi R sqrt(rho/G)/(0.1631 nu + 0.8766), shorter than any.
//            A step is a fifth of it.   [Li, Xu & Thornton 2005]
#pragma once

namespace salvo::solver {

struct Setup;

struct ContactTime {
  double duration = 0;      ///< of the shortest impact, or the Rayleigh time, s
  double step = 0;          ///< the step that is chosen when the scene gives none, s
  double longest_step = 0;  ///< beyond it impacts are not followed, s
};

/// Of a set-up with a contact law, from the lightest and smallest particles that its emitters make;
/// dt is not looked at.
ContactTime contact_time(const Setup& setup);

}  // namespace salvo::solver
