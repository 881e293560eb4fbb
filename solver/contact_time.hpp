// How long a contact lasts, and the time step that follows it.
//
//   linear   t = pi sqrt(m*/k) of the lightest spheres: see kernels::impact_duration. A step is
//            t/50.
//   Hertz    An impact takes longer the slower it is. The wave that crosses a sphere takes the
//            Rayleigh time, pi R sqrt(rho/G)/(0.1631 nu + 0.8766), shorter than any. At a given
//            mass it is shortest in the largest sphere. A step is a fifth of it.
//            [Li, Xu & Thornton 2005]
//
// Strong dashpots, and springs against slip that are stiffer than the normal ones, shorten it.
#pragma once

namespace salvo::solver {

struct Setup;

struct ContactTime {
  const char* of = "";      ///< what is the fastest, in words
  double duration = 0;      ///< how long that lasts, s
  double step = 0;          ///< the step that is chosen when the scene gives none, s
  double longest_step = 0;  ///< beyond it impacts are not followed, s
};

/// Of a set-up with a contact law, from the particles that its emitters may make; dt is not looked
/// at.
ContactTime contact_time(const Setup& setup);

}  // namespace salvo::solver
