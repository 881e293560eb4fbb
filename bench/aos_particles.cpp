#include "bench/aos_particles.hpp"

#include <cmath>

namespace book {

Air air;

void Particle::CalcLoads() {
  vForces.x = vGravity.x;
  vForces.y = vGravity.y;
  vForces.z = vGravity.z;

  const Vector flow{vVelocity.x - air.wind.x, vVelocity.y - air.wind.y, vVelocity.z - air.wind.z};
  fSpeed = std::sqrt(flow.x * flow.x + flow.y * flow.y + flow.z * flow.z);
  if (fSpeed > 0) {
    const Vector direction{-flow.x / fSpeed, -flow.y / fSpeed, -flow.z / fSpeed};
    const float drag = 0.5F * air.density * fSpeed * fSpeed * (3.14159F * fRadius * fRadius) *
                       air.drag_coefficient;
    vForces.x += direction.x * drag;
    vForces.y += direction.y * drag;
    vForces.z += direction.z * drag;
  }
}

void Particle::UpdateBodyEuler(double dt) {
  const auto h = static_cast<float>(dt);
  vPreviousPosition = vPosition;
  vVelocity.x += vForces.x / fMass * h;
  vVelocity.y += vForces.y / fMass * h;
  vVelocity.z += vForces.z / fMass * h;
  vPosition.x += vVelocity.x * h;
  vPosition.y += vVelocity.y * h;
  vPosition.z += vVelocity.z * h;
}

void step(Particle* particles, long count, double dt) {
  for (long i = 0; i < count; ++i) {
    particles[i].CalcLoads();
    particles[i].UpdateBodyEuler(dt);
  }
}

}  // namespace book
