// A quantity of a model whose zero ends a row. A model lists its events and gives the quantities'
// values over any lane type, so that the same formula yields their rates (kernels::Dual):
//
//   static constexpr std::array<Event, 1> events{{{"ground", "it comes down",
//   Direction::falling}}}; template <class X> std::array<X, 1> quantities(X t, const std::array<X,
//   ..>& s, const std::array<X, ..>& p) const;
#pragma once

#include <cstdint>
#include <string_view>

namespace salvo::models {

/// Which way the quantity goes through zero.
enum class Direction : std::uint8_t { falling, rising, either };

struct Event {
  std::string_view name;
  std::string_view meaning;
  Direction direction;
};

}  // namespace salvo::models
