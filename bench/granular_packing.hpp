// Equal spheres that fly about in a closed cubic box, and the linear contact law between them: what
// contact/dense and its peer are measured on. SI units.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace salvo::bench {

/// n spheres in the box [0, edge]^3; vectors of 3n numbers x, y, z, x, y, z, .. in order of id.
struct GranularPacking {
  double edge;
  double radius;
  double density;
  std::vector<double> position;
  std::vector<double> velocity;
  std::vector<double> spin;  // angular velocity, rad/s

  std::size_t count() const { return position.size() / 3; }
  /// Of one sphere, kg.
  double mass() const;
};

/// Springs and dashpots along the normal and across it, with Coulomb's limit. Term by term in
/// bench/lammps_peer.hpp.
struct GranularLaw {
  double normal_stiffness;      // N/m
  double tangential_stiffness;  // N/m
  double normal_damping;        // of a pair's effective mass, 1/s
  double tangential_damping;    // of a pair's effective mass, 1/s
  double friction;
  bool limit_damping;  // the normal force never pulls
};

/// The law whose damping gives two spheres of `mass` this restitution, with 2/7 of the normal
/// stiffness and half of the normal damping across it; the dashpot never pulls, which raises the
/// restitution a little.
GranularLaw granular_law(double normal_stiffness, double restitution, double friction, double mass);

/// How long two spheres of `mass` touch: half a period of their damped spring, s.
double collision_time(const GranularLaw& law, double mass);

/// `count` spheres that fill `fraction` of the box, none in touch with another or a wall: jittered
/// sites of a face-centred cubic lattice, all of them where dense, drawn from many where sparse.
/// Components of the velocities are normal with the width `speed`, and so are those of the spins
/// times the radius. Throws std::invalid_argument where the lattice does not fit.
GranularPacking agitated_packing(std::size_t count, double fraction, double radius, double density,
                                 double speed, std::uint64_t seed);

/// Beads of glass, 1 mm across, of restitution 0.8, whose speeds of about 1 m/s keep the lists
/// busy: after 90 steps the fastest needs 17 to 20 steps for half the skin.
struct GranularScene {
  std::string name;
  double fraction;
  double speed;  // m/s

  static constexpr double radius = 5e-4;
  static constexpr double skin = 0.2 * radius;
  static constexpr int rebuild_every = 15;

  GranularPacking packing(std::size_t count) const;
  static GranularLaw law();
  /// A fiftieth of a collision.
  static double dt();
  /// What both sides are told alike, in words.
  static std::string conditions();
};
const std::vector<GranularScene>& granular_scenes();

}  // namespace salvo::bench
