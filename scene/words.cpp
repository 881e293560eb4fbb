#include "scene/words.hpp"

namespace salvo::scene {

using models::ObstacleShape;
using soa::Precision;
using solver::EmitterKind;
using solver::IntegratorKind;

template <>
const Words& words_of<Precision>() {
  static const Words words{{"float", Precision::float32, "32 bits"},
                           {"double", Precision::float64, "64 bits"}};
  return words;
}

template <>
const Words& words_of<IntegratorKind>() {
  static const Words words{
      {"explicit_euler", IntegratorKind::explicit_euler, "order 1"},
      {"semi_implicit_euler", IntegratorKind::semi_implicit_euler,
       "order 1, keeps energies bounded; the book's"},
      {"improved_euler", IntegratorKind::improved_euler, "order 2, Heun's method"},
      {"runge_kutta_4", IntegratorKind::runge_kutta_4, "order 4"},
      {"velocity_verlet", IntegratorKind::velocity_verlet, "order 2, keeps energies bounded"}};
  return words;
}

template <>
const Words& words_of<EmitterKind>() {
  static const Words words{
      {"burst", EmitterKind::burst, "from a point or ball, in all directions"},
      {"shell", EmitterKind::shell, "from the surface of a sphere, outward"},
      {"cone", EmitterKind::cone, "from a point or ball, into a cone"},
      {"jet", EmitterKind::jet, "the same, at a rate for a duration"},
      {"book_explosion", EmitterKind::book_explosion,
       "section 2.6 of the book: in the x-y plane, whole-number speeds in strength/2 to strength, "
       "whole degrees, lives of 80 to 100 % of the longest"},
      {"energy_explosion", EmitterKind::energy_explosion,
       "section 18.4.1 of the book: speeds from an energy budget that is never exceeded"},
      {"lattice", EmitterKind::lattice, "at the sites of a lattice, without overlap"}};
  return words;
}

template <>
const Words& words_of<ObstacleShape>() {
  static const Words words{
      {"plane", ObstacleShape::plane, "everything on the far side of the normal is solid"},
      {"sphere", ObstacleShape::sphere},
      {"box", ObstacleShape::box},
      {"capsule", ObstacleShape::capsule, "all within `radius` of a segment"},
      {"cylinder", ObstacleShape::cylinder, "with flat ends"},
      {"height_field", ObstacleShape::height_field,
       "heights along y on a grid in x and z; solid below"},
      {"mesh", ObstacleShape::mesh,
       "triangles of a file, with two sides; of particles that touch"}};
  return words;
}

}  // namespace salvo::scene
