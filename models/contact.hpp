// Particles on fixed obstacles: what an impact does to the velocity, and how the rest of the step
// goes on.   [Bourg & Bywalec 5.2-5.4, 8.4]
//
// Swept response. Where the chord from x_n to x_(n+1) meets a surface, at the fraction s, the
// kinetic energy is taken as linear between the ends, as it is for velocity Verlet under a constant
// force. With dv = v_(n+1) - v_n:
//
//   |v|^2 = (1 - s)|v_n|^2 + s|v_(n+1)|^2 = |v_n + s dv|^2 + s (1 - s)|dv|^2
//
// The last term goes to the normal velocity. After the impact the remaining time goes on under the
// mean acceleration dv/dt, along a new chord that is tested in turn. A particle that falls back
// before the end of the step hops and meets the surface again; one that would hop more often than a
// step has impacts slides, under Coulomb friction.
#pragma once

#include <cassert>
#include <span>

#include "kernels/impact.hpp"
#include "kernels/motion.hpp"
#include "models/obstacle.hpp"
#include "models/particle.hpp"
#include "models/sweep.hpp"

namespace salvo::models {
inline namespace SALVO_ISA {

using kernels::Motion;

/// Whole numbers, one a lane.
template <class V>
struct ContactCount {
  V impacts{0};  // surfaces met at speed
  V rests{0};    // steps in which a particle was laid on a surface because it had no impacts left
};

template <class V>
class Contact {
 public:
  using T = typename V::Real;
  using Mask = typename V::Mask;

  /// The obstacles, of unit axes and rotations (see `normalized`), outlive this object.
  /// Construction costs nothing.
  Contact(std::span<const Obstacle> obstacles, const ContactSettings& settings)
      : obstacles_(obstacles),
        max_impacts_(settings.max_impacts),
        interpolate_at_plane_(settings.interpolate_at_plane) {
    for ([[maybe_unused]] const Obstacle& obstacle : obstacles) assert(is_normalized(obstacle));
  }

  /// Swept response: the end of a step of `dt` that went from `before` to `after` without contact.
  /// Lanes that are not active, and those that meet nothing, end in `after`.
  [[gnu::noinline]] Motion<V> resolve(const Motion<V>& before, const Motion<V>& after,
                                      const ParticleRow<V>& row, V dt, Mask active,
                                      ContactCount<V>& count) const {
    const Sweep<V> sweep(before.position, after.position - before.position, row.radius);
    if (!sweep.may_meet(obstacles_, active)) return after;
    return resolve_near(before, after, row, dt, active, count);
  }

  /// The book's impulse: particles that penetrate and approach an obstacle get v += J n/m and are
  /// pushed out along the normal, obstacle after obstacle. To be called at the start of a step.
  /// [5.2, 5.4]
  [[gnu::noinline]] Motion<V> respond(const Motion<V>& before, const ParticleRow<V>& row,
                                      Mask active, ContactCount<V>& count) const {
    Motion<V> motion = before;
    for (const Obstacle& obstacle : obstacles_) {
      const Touch touch = touching(obstacle, motion.position, motion.velocity, row, active);
      motion.velocity = select(touch.mask, motion.velocity + touch.change, motion.velocity);
      motion.position =
          select(touch.mask, motion.position - touch.normal * touch.gap, motion.position);
      count.impacts = count.impacts + select(touch.mask, V(1), V(0));
    }
    return motion;
  }

  struct BookForce {
    Mask mask;         // lanes in contact
    Motion<V> motion;  // their state at the end of the step
  };

  /// The book's force: in a step with contact the impact forces n J/dt of all obstacles, each from
  /// the velocity before the impact, are the only force. Lanes of the mask have taken the whole
  /// step (semi-implicit Euler).   [8.4]
  [[gnu::noinline]] BookForce book_force(const Motion<V>& before, const ParticleRow<V>& row, V dt,
                                         Mask active, ContactCount<V>& count) const {
    Mask hit(false);
    Vec3<V> position = before.position;
    Vec3<V> velocity = before.velocity;
    for (const Obstacle& obstacle : obstacles_) {
      const Touch touch = touching(obstacle, position, before.velocity, row, active);
      velocity = select(touch.mask, velocity + touch.change, velocity);
      Vec3<V> out = position - touch.normal * touch.gap;
      if (interpolate_at_plane_ && obstacle.shape == ObstacleShape::plane) {
        // Back along the path of the last step, x_n - v_n dt to x_n, to the height of contact; not
        // beyond its start.
        const V back = min(touch.gap / select(touch.mask, touch.arrival, V(-1)), dt);
        out -= (before.velocity - touch.normal * touch.arrival) * back;
      }
      position = select(touch.mask, out, position);
      hit = hit | touch.mask;
      count.impacts = count.impacts + select(touch.mask, V(1), V(0));
    }
    return {hit, {position + velocity * dt, velocity}};
  }

 private:
  // ---- swept ------------------------------------------------------------------------------------

  // The normals of the last two surfaces that a particle slid on within the step.
  struct Supports {
    Mask last_held{false};
    Mask earlier_held{false};
    Vec3<V> last{V(0), V(0), V(0)};
    Vec3<V> earlier{V(0), V(0), V(0)};

    void add(Mask slides, Mask left, Vec3<V> normal) {
      earlier_held = (earlier_held & !(left | slides)) | (last_held & slides);
      earlier = select(slides, last, earlier);
      last_held = (last_held & !left) | slides;
      last = select(slides, normal, last);
    }
  };

  [[gnu::noinline]] Motion<V> resolve_near(const Motion<V>& before, const Motion<V>& after,
                                           const ParticleRow<V>& row, V dt, Mask active,
                                           ContactCount<V>& count) const {
    Leg<V> leg{before.position,
               after.position - before.position,
               before.velocity,
               after.velocity,
               dt,
               V(0)};
    Hit<V> hit = first_hit(leg, row.radius, active);
    const Mask met = hit.found;
    if (!any(met)) return after;

    const Vec3<V> change = after.velocity - before.velocity;
    const Vec3<V> acceleration{change.x / dt, change.y / dt, change.z / dt};
    const V strength = norm(acceleration);
    Motion<V> result = after;
    Mask going = met;
    Mask rested(false);
    V contacts(0);
    V impacts(0);
    Supports supports;
    // Each turn is a contact, of which a lane has at most max_impacts + 1, or the end of a hop that
    // began with one: this ends.
    while (any(going)) {
      // Where the leg ends: on a surface, or after a hop.
      const V s = select(hit.found, hit.fraction, V(1));
      const Vec3<V> position = leg.position + leg.chord * s;
      const V time = leg.duration * (V(1) - s) + leg.remaining;
      const Vec3<V> gain = leg.end_velocity - leg.velocity;
      const Vec3<V> velocity = select(hit.found, leg.velocity + gain * s, leg.end_velocity);

      // The impact. A normal velocity below rounding is none. The energy is that of the rounded
      // position: a surface between two numbers would always round it to the same side.
      const Vec3<V> n = hit.normal;
      const V arrival = dot(n, velocity);
      const Vec3<V> rounding = (position - leg.position) - leg.chord * s;
      const V missing = s * (V(1) - s) * norm_squared(gain) + V(2) * dot(acceleration, rounding);
      const V speed = sqrt(max(arrival * arrival + missing, V(0)));
      const Mask impact = hit.found & (arrival < -(V(grazing<T>) * norm(velocity)));
      const V e = kernels::effective_restitution(hit.restitution, row.mass, hit.inverse_mass);
      const V rebound = select(impact, max(e, V(0)) * speed, speed);
      const Vec3<V> tangential = velocity - n * arrival;
      const V kept = select(
          impact, kernels::friction_factor(norm(tangential), speed + rebound, hit.friction), V(1));
      const Vec3<V> slip = tangential * kept;
      impacts = impacts + select(impact, V(1), V(0));
      contacts = contacts + select(hit.found, V(1), V(0));
      const Mask exhausted = hit.found & (contacts > max_impacts_);
      result = select(exhausted, {position, slip}, result);
      going = going & !exhausted;

      // What follows: flight for the rest of the step, a hop that ends on the surface, or sliding.
      // A hop no higher than positions resolve is none.
      const V toward = -dot(n, acceleration);
      const V unresolved = unresolved_length(position, position - before.position);
      const V hops_left = max_impacts_ + V(1) - contacts;
      const Mask returns = hit.found & (V(2) * rebound <= toward * time);
      const Mask is_low = (toward > V(0)) & (rebound * rebound <= V(2) * toward * unresolved);
      const Mask slides = (hit.found & is_low) |
                          (returns & (V(2) * rebound * hops_left <= toward * time)) |
                          (hit.found & (!impact) & supports.last_held);
      const Mask hops = returns & !slides;
      rested = rested | exhausted | (slides & (rebound * rebound > V(2) * strength * unresolved));
      leg.position = position;
      leg.velocity = select(hit.found,
                            kernels::add_along_normal(velocity * kept, n, rebound - arrival * kept,
                                                      kernels::unit_excess(n)),
                            velocity);
      leg.duration = select(hops, min(V(2) * rebound / select(hops, toward, V(1)), time), time);
      leg.remaining = time - leg.duration;
      leg.end_velocity = leg.velocity + acceleration * leg.duration;
      leg.chord = (leg.velocity + acceleration * (V(0.5) * leg.duration)) * leg.duration;
      if (any(slides)) slide(leg, slides, n, slip, acceleration, toward, hit.friction, supports);
      supports.add(slides, hit.found & !slides, n);

      hit = first_hit(leg, row.radius, going & (extent(leg.chord) > V(0)));
      const Mask done = going & (!hit.found) & !(leg.remaining > V(0));
      result = select(done, {leg.position + leg.chord, leg.end_velocity}, result);
      going = going & !done;
    }

    // What was at rest, is at rest and has moved by no more than rounding has not moved.
    const Mask at_rest =
        met & (norm_squared(before.velocity) == V(0)) & (norm_squared(result.velocity) == V(0)) &
        (norm(result.position - before.position) <= V(2 * grazing<T>) * norm(before.position));
    result.position = select(at_rest, before.position, result.position);
    count.impacts = count.impacts + select(at_rest, V(0), impacts);
    count.rests = count.rests + select(rested & !at_rest, V(1), V(0));
    return result;
  }

  Hit<V> first_hit(const Leg<V>& leg, V radius, Mask active) const {
    return Sweep<V>(leg.position, leg.chord, radius).first_hit(obstacles_, leg, active);
  }

  // Turns the leg of the lanes `slides` into sliding from its start: `slip` and the tangential
  // acceleration along the surface, friction mu |a.n| against the velocity that would result, at
  // most what stops it.
  static void slide(Leg<V>& leg, Mask slides, Vec3<V> n, Vec3<V> slip, Vec3<V> acceleration,
                    V toward, V friction, const Supports& supports) {
    const V time = leg.duration;
    Vec3<V> pull = acceleration + n * toward;
    V pressure = max(toward, V(0));

    // Between two surfaces only the line that they share is left, between three not even that.
    const Vec3<V> free = slip + pull * time;
    const V level = -(V(grazing<T>) * norm(free));
    const Mask on_last = slides & supports.last_held & (dot(free, supports.last) < level);
    const Mask on_earlier =
        slides & (!on_last) & supports.earlier_held & (dot(free, supports.earlier) < level);
    const Mask wedged = on_last | on_earlier;
    const Vec3<V> line = cross(n, select(on_last, supports.last, supports.earlier));
    const V sine = norm(line);
    const Vec3<V> crease = line * (V(1) / select(sine > V(0), sine, V(1)));
    slip = select(wedged, crease * dot(slip, crease), slip);
    pull = select(wedged, crease * dot(acceleration, crease), pull);
    pressure = select(wedged, norm(acceleration - pull), pressure);
    const Vec3<V> along = slip + pull * time;
    const Vec3<V> third = select(on_last, supports.earlier, supports.last);
    const Mask blocked = ((on_last & supports.earlier_held) | (on_earlier & supports.last_held)) &
                         (dot(along, third) * sine < -(V(grazing<T>) * norm(along)));
    const Vec3<V> nothing{V(0), V(0), V(0)};
    slip = select(blocked, nothing, slip);
    pull = select(blocked, nothing, pull);

    const Vec3<V> wish = slip + pull * time;
    const Vec3<V> end = wish * kernels::friction_factor(norm(wish), pressure * time, friction);
    // At the mean velocity, unless the particle turned around on the way: friction never pushes on.
    const Vec3<V> twice_mean = slip + end;
    const Vec3<V> mean = select(dot(wish, twice_mean) >= V(0), twice_mean * V(0.5), end);
    leg.velocity = select(slides, slip, leg.velocity);
    leg.end_velocity = select(slides, end, leg.end_velocity);
    leg.chord = select(slides, mean * time, leg.chord);
  }

  // ---- the book's responses ---------------------------------------------------------------------

  struct Touch {
    Mask mask;  // penetrating and approaching
    V gap;      // negative inside, m
    V arrival;  // normal velocity, m/s
    Vec3<V> normal;
    Vec3<V> change;  // of the velocity, m/s
  };

  static Touch touching(const Obstacle& obstacle, Vec3<V> position, Vec3<V> velocity,
                        const ParticleRow<V>& row, Mask active) {
    const Vec3<V> p = position - broadcast<V>(obstacle.center);
    const bool field = obstacle.shape == ObstacleShape::height_field;
    const Surface<V> at =
        field ? field_surface(*obstacle.samples, p, row.radius) : solid_surface(obstacle, p);
    Touch touch;
    touch.gap = field ? at.distance : at.distance - row.radius;
    touch.normal = at.normal;
    touch.arrival = dot(velocity, at.normal);
    touch.mask = active & (touch.gap <= V(0)) & (touch.arrival < V(0));
    const V inverse_mass = V(1) / row.mass;
    const V impulse = kernels::normal_impulse(touch.arrival, V(obstacle.restitution), inverse_mass,
                                              V(1 / obstacle.mass));
    const V change = impulse * inverse_mass;
    const Vec3<V> slip = velocity - at.normal * touch.arrival;
    const V kept = kernels::friction_factor(norm(slip), change, V(obstacle.friction));
    touch.change = at.normal * change - slip * (V(1) - kept);
    return touch;
  }

  std::span<const Obstacle> obstacles_;
  V max_impacts_;
  bool interpolate_at_plane_;
};

}  // namespace SALVO_ISA
}  // namespace salvo::models
