// A particle among the forces of a scene: its right-hand side, v' = a(x, v, t).   [Bourg &
// Bywalec 2.6, 3, 6.2, 8.1-8.3]
//
//   a = g + sum GM d/|d|^3 - 1/2 rho (Cd A)/m |u| u - (c/m) u - g rho V/m + blasts,     u = v -
//   wind(x, t)
#pragma once

#include <cstddef>

#include "kernels/forces.hpp"
#include "kernels/motion.hpp"
#include "models/force_settings.hpp"

namespace salvo::models {

/// Coefficients that depend on time alone, computed once for each instant of a step and shared by
/// every particle: 3 axes x 16 gust coefficients (see kernels::gust_sum), then one amplitude a
/// blast.
inline constexpr std::size_t gust_coefficients = 3 * 16;

constexpr std::size_t instant_coefficients(std::size_t blasts) {
  return gust_coefficients + blasts;
}

inline namespace SALVO_ISA {

using kernels::Vec3;

/// What a particle brings to the right-hand side besides its motion.
template <class V>
struct ParticleRow {
  V mass;       // kg
  V radius;     // m
  V drag_area;  // m^2
};

template <class V>
Vec3<V> broadcast(const Triple& triple) {
  return {V(triple[0]), V(triple[1]), V(triple[2])};
}

/// The parts of the right-hand side that stay the same for one particle.
template <class V>
struct ParticleCoefficients {
  V inverse_mass;  // 1/kg
  V drag_factor;   // 1/2 rho (Cd A)/m, 1/m
  V buoyancy;      // rho V/m, the displaced mass over the particle's
  V wind_push;     // 1/2 rho (Cd A)/m |wind|, the book's constant push over the wind, 1/s
};

/// Those that PlainForces wants.
template <class V>
ParticleCoefficients<V> plain_coefficients(V mass, V drag_area, V half_density) {
  ParticleCoefficients<V> c;
  c.inverse_mass = V(1) / mass;
  c.drag_factor = half_density * drag_area * c.inverse_mass;
  return c;
}

/// Gravity, drag and a uniform wind: all that many scenes have. Calls nothing, so that packs stay
/// in registers.
template <class V>
struct PlainForces {
  explicit PlainForces(const ForceSettings& settings)
      : gravity(broadcast<V>(settings.gravity)),
        wind(broadcast<V>(settings.windy ? settings.wind.velocity : Triple{})),
        linear_drag(settings.linear_drag) {}

  /// Acceleration in m/s^2. `quadratic` and `linear` say which drag there is: bool, or
  /// std::bool_constant where a kernel knows.
  template <class Quadratic, class Linear>
  Vec3<V> acceleration(Vec3<V> velocity, const ParticleCoefficients<V>& c, Quadratic quadratic,
                       Linear linear) const {
    const Vec3<V> flow = velocity - wind;
    Vec3<V> a = gravity;
    if (quadratic) a += kernels::quadratic_drag(flow, c.drag_factor);
    if (linear) a += kernels::linear_drag(flow, linear_drag, c.inverse_mass);
    return a;
  }

  Vec3<V> gravity;  // m/s^2
  Vec3<V> wind;     // m/s
  V linear_drag;    // kg/s
};

template <class V>
class ParticleForces {
 public:
  using T = typename V::Real;

  explicit ParticleForces(const ForceSettings& settings)
      : settings_(settings),
        plain_(settings),
        half_density_(0.5 * settings.air_density),
        drag_(settings.quadratic_drag),
        linear_(settings.linear_drag != 0),
        still_air_(settings.drag_law == DragLaw::book_still_air),
        uniform_wind_(!settings.gusty &&
                      (!settings.windy || settings.wind.profile == WindProfile::uniform)),
        extra_(!settings.point_gravity.empty() || settings.buoyancy || !settings.blasts.empty()) {
    using S = kernels::ScalarLane<double>;
    if (settings.windy && settings.wind.profile == WindProfile::log_law) {
      inverse_log_reference_ =
          V(1 / log(S(settings.wind.reference_height / settings.wind.roughness)).value());
    }
    const Triple& w = settings.wind.velocity;
    wind_speed_ =
        V(settings.windy ? sqrt(S(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])).value() : 0.0);
    gust_direction_ = broadcast<V>(settings.gust.direction);
    gust_wave_number_ = V(2 * kernels::pi / settings.gust.length);
  }

  ParticleCoefficients<V> coefficients(const ParticleRow<V>& row) const {
    ParticleCoefficients<V> c = plain_coefficients(row.mass, row.drag_area, half_density_);
    c.buoyancy = V(settings_.air_density) * kernels::sphere_volume(row.radius) * c.inverse_mass;
    c.wind_push = c.drag_factor * wind_speed_;
    return c;
  }

  /// True when gravity, drag and a uniform wind are all there is: plain_acceleration() then is the
  /// right-hand side.
  bool plain() const { return uniform_wind_ && !still_air_ && !extra_; }

  Vec3<V> plain_acceleration(Vec3<V> velocity, const ParticleCoefficients<V>& c) const {
    return plain_.acceleration(velocity, c, drag_, linear_);
  }

  /// Acceleration in m/s^2; `instant` points at the coefficients of this instant.
  Vec3<V> acceleration(Vec3<V> position, Vec3<V> velocity, const ParticleCoefficients<V>& c,
                       const T* instant) const {
    Vec3<V> a = plain_.gravity;
    const Vec3<V> air = still_air_ ? Vec3<V>{V(0), V(0), V(0)} : wind(position, instant);
    const Vec3<V> flow = velocity - air;
    if (drag_) a += kernels::quadratic_drag(flow, c.drag_factor);
    if (drag_ && still_air_) a += plain_.wind * c.wind_push;
    if (linear_) a += kernels::linear_drag(flow, plain_.linear_drag, c.inverse_mass);
    if (extra_) a += extra(position, c, instant);
    return a;
  }

  /// Velocity of the air, m/s.
  Vec3<V> wind(Vec3<V> position, const T* instant) const {
    Vec3<V> air = plain_.wind;
    const Wind& w = settings_.wind;
    if (settings_.windy && w.profile != WindProfile::uniform) {
      const V height = dot(position, broadcast<V>(settings_.up)) - V(w.ground);
      air = air * (w.profile == WindProfile::power_law
                       ? kernels::power_law_profile(height, V(w.reference_height), V(w.exponent))
                       : kernels::log_law_profile(height, V(w.roughness), inverse_log_reference_));
    }
    if (settings_.gusty) {
      const V phase = dot(position, gust_direction_) * gust_wave_number_;
      const V s = sin(phase);
      const V c = cos(phase);
      air += Vec3<V>{kernels::gust_sum(s, c, instant), kernels::gust_sum(s, c, instant + 16),
                     kernels::gust_sum(s, c, instant + 32)};
    }
    return air;
  }

 private:
  Vec3<V> extra(Vec3<V> position, const ParticleCoefficients<V>& c, const T* instant) const {
    Vec3<V> a{V(0), V(0), V(0)};
    for (const PointGravity& pull : settings_.point_gravity) {
      a += kernels::point_gravity(position, broadcast<V>(pull.center), V(pull.strength),
                                  V(pull.softening));
    }
    if (settings_.buoyancy) a -= plain_.gravity * c.buoyancy;
    const T* amplitude = instant + gust_coefficients;
    for (const Blast& blast : settings_.blasts) {
      a += kernels::blast(position, broadcast<V>(blast.center), V(*amplitude) * c.inverse_mass,
                          V(blast.reference_radius), blast.exponent);
      ++amplitude;
    }
    return a;
  }

  const ForceSettings& settings_;
  PlainForces<V> plain_;
  V half_density_;
  V wind_speed_{0};
  V inverse_log_reference_{0};
  Vec3<V> gust_direction_;
  V gust_wave_number_;
  bool drag_;
  bool linear_;
  bool still_air_;
  bool uniform_wind_;
  bool extra_;
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
