#include "models/standard_atmosphere.hpp"

#include <iterator>

#include "kernels/math.hpp"

namespace salvo::models {

namespace {

struct Layer {
  double base;         // m, geopotential
  double lapse;        // K/m
  double temperature;  // K, at the base
  double pressure;     // Pa, at the base
};

constexpr Layer layers[] = {{0, -0.0065, 288.15, 101325},
                            {11000, 0, 216.65, 22632.06397346293},
                            {20000, 0.001, 216.65, 5474.8886696777796},
                            {32000, 0.0028, 228.65, 868.01868475522733},
                            {47000, 0, 270.65, 110.90630555496588},
                            {51000, -0.0028, 270.65, 66.938873118687266},
                            {71000, -0.002, 214.65, 3.9564204280407287}};

constexpr double g0 = 9.80665;               // m/s^2
constexpr double gas = 8314.32 / 28.9644;    // J/(kg K)
constexpr double heat_capacity_ratio = 1.4;  // of air

}  // namespace

AirState standard_air(double geopotential_height) {
  using S = kernels::ScalarLane<double>;
  const Layer* layer = std::begin(layers);
  while (layer + 1 != std::end(layers) && geopotential_height >= layer[1].base) ++layer;
  const double above = geopotential_height - layer->base;
  AirState air{};
  air.temperature = layer->temperature + layer->lapse * above;
  const S ratio = layer->lapse == 0
                      ? exp(S(-g0 * above / (gas * layer->temperature)))
                      : pow(S(layer->temperature / air.temperature), S(g0 / (gas * layer->lapse)));
  air.pressure = layer->pressure * ratio.value();
  air.density = air.pressure / (gas * air.temperature);
  air.speed_of_sound = sqrt(S(heat_capacity_ratio * gas * air.temperature)).value();
  return air;
}

}  // namespace salvo::models
