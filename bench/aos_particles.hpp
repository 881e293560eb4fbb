// The book's particle class (Bourg & Bywalec 8.1-8.4), its fields and no others, one object a
// particle.
#pragma once

namespace book {

struct Vector {
  float x = 0, y = 0, z = 0;
};

class Particle {
 public:
  float fMass = 1;
  Vector vPosition;
  Vector vVelocity;
  float fSpeed = 0;
  Vector vForces;
  float fRadius = 0.1F;
  Vector vGravity;
  Vector vPreviousPosition;
  Vector vImpactForces;
  bool bCollision = false;

  void CalcLoads();
  void UpdateBodyEuler(double dt);
};
static_assert(sizeof(Particle) <= 128);

/// Gravity, quadratic drag and uniform wind, relative to the flow, as the salvo benchmark it is
/// compared with.
struct Air {
  Vector wind;
  float density = 1.225F;
  float drag_coefficient = 0.6F;
};
extern Air air;

void step(Particle* particles, long count, double dt);

}  // namespace book
