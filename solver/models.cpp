#include "solver/models.hpp"

#include <array>

namespace salvo::solver {

std::span<const ModelEntry> models() {
  static constexpr std::array<ModelEntry, 8> entries{{
      {"projectile", "a point mass with a standard drag function in the standard atmosphere",
       &projectile_kernels},
      {"shot_in_air", "a point mass with quadratic drag of a constant coefficient",
       &shot_in_air_kernels},
      {"ball", "a spinning sphere with drag and Magnus lift", &ball_kernels},
      {"cannon", "a shell with linear drag, from a barrel, at a box", &cannon_kernels},
      {"rocket", "a rocket of up to three stages in the standard atmosphere", &rocket_kernels},
      {"boat", "a boat with thrust and linear resistance", &boat_kernels},
      {"harmonic_oscillator", "the damped harmonic oscillator", &harmonic_oscillator_kernels},
      {"lorenz", "the Lorenz equations", &lorenz_kernels},
  }};
  return entries;
}

}  // namespace salvo::solver
