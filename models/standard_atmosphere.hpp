// The US Standard Atmosphere 1976 (NASA-TM-X-74335), which is ICAO's up to 80 km: layers of
// constant gradient of temperature over geopotential height H = r z/(r + z).
//
//   T = Tb + L (H - Hb)
//   p = pb (Tb/T)^(g0 M/(R L)),  or  pb e^(-g0 M (H - Hb)/(R Tb)) where L is zero
#pragma once

namespace salvo::models {

struct AirState {
  double temperature;     // K
  double pressure;        // Pa
  double density;         // kg/m^3
  double speed_of_sound;  // m/s
};

/// Effective radius of the Earth, m; geopotential heights between which the atmosphere is defined,
/// m.
inline constexpr double atmosphere_radius = 6356766;
inline constexpr double lowest_geopotential = -5000;
inline constexpr double highest_geopotential = 84852;

/// At a geopotential height between the two.
AirState standard_air(double geopotential_height);

}  // namespace salvo::models
