// The standard drag functions of small arms and artillery: Cd of the standard projectile against
// Mach number.
//
//   a = -(pi/8) rho Cd(M) |u| u / BC,     BC = m/(i d^2) in kg/m^2 (1 lb/in^2 = 703.06957963916
//   kg/m^2)
#pragma once

#include <array>
#include <span>
#include <string_view>

namespace salvo::models {

struct DragPoint {
  double mach;
  double cd;
};

struct DragFunction {
  std::string_view name;
  std::string_view projectile;
  std::span<const DragPoint> points;  ///< ascending Mach numbers, multiples of 1/80
};

extern const std::array<DragFunction, 7> drag_functions;

/// Where a user's own drag function comes behind them.
inline constexpr std::size_t own_drag_function = 7;

}  // namespace salvo::models
