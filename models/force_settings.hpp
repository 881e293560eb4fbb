// What acts on the particles of a scene, as plain numbers: SI units, double precision, no
// instruction set.
#pragma once

#include <array>
#include <vector>

namespace salvo::models {

using Triple = std::array<double, 3>;

struct PointGravity {
  Triple center{};       // m
  double strength = 0;   // GM, m^3/s^2; positive attracts
  double softening = 0;  // m
};

enum class WindProfile { uniform, power_law, log_law };

/// Mean wind. With a profile, `velocity` is that at the reference height, and height is measured
/// along `up` from `ground`.
struct Wind {
  Triple velocity{};  // m/s
  WindProfile profile = WindProfile::uniform;
  double reference_height = 10;  // m
  double exponent = 1.0 / 7.0;   // power law
  double roughness = 0.03;       // m, log law
  double ground = 0;             // m along `up`
};

/// Gusts: for each axis the sum of 8 sinusoids of wavelengths length/1 .. length/8 along
/// `direction`, carried along at `speed`, with phases drawn from the scene's seed. Each axis has
/// the given standard deviation.
struct Gust {
  Triple standard_deviation{};  // m/s
  double length = 100;          // m
  double speed = 0;             // m/s; zero: the mean wind's
  Triple direction{};           // zero: the mean wind's, or x without one
};

/// Acceleration J/(m tau) (r0/max(r, r0))^exponent e^(-(t - t0)/tau), outward, from t0 on.
struct Blast {
  Triple center{};              // m
  double time = 0;              // t0, s
  double impulse = 0;           // J at the reference radius, N s
  double duration = 1e-3;       // tau, s
  double reference_radius = 1;  // r0, m
  int exponent = 3;
};

/// The book's chapter 8 takes drag in still air and the wind as a constant push; physics takes the
/// flow past the body.
enum class DragLaw { relative_flow, book_still_air };

struct ForceSettings {
  Triple gravity{0, -9.80665, 0};  // m/s^2
  Triple up{0, 1, 0};              // unit vector; heights of wind profiles
  std::vector<PointGravity> point_gravity;
  double air_density = 1.225;  // kg/m^3
  bool quadratic_drag = false;
  DragLaw drag_law = DragLaw::relative_flow;
  double linear_drag = 0;  // kg/s
  bool buoyancy = false;
  bool windy = false;
  Wind wind;
  bool gusty = false;
  Gust gust;
  std::vector<Blast> blasts;
};

}  // namespace salvo::models
