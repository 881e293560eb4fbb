// clang-format off
// A quantity of a model whose zeros are of interest. A model lists its events and gives the value
// of each over any lane type, so that the same formula yields its rate (kernels::Dual):
//
//   static constexpr std::array<Event, 1> events{{{"ground", "it comes down", Direction::falling, true}}};
//   template <class X>
//   X quantity(std::size_t event, X t, const std::array<X, ..>& s, const std::array<X, ..>& p) const;
//
// A zero that needs more to count, such as the face of a box, is left to
//
//   Mask accepts(std::size_t event, const std::array<V, ..>& s, const std::array<V, ..>& p) const;
// clang-format on
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
  bool stops;  ///< ends a row unless the user says otherwise
};

}  // namespace salvo::models
