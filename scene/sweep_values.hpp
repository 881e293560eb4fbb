// Values of scenes of trajectories that are more than a number or a word.
#pragma once

#include <optional>
#include <string>

#include "scene/document.hpp"
#include "scene/words.hpp"
#include "solver/variation.hpp"

namespace salvo::scene {

/// An input as it is written.
struct InputValue {
  bool given = false;
  solver::Variation variation;
  std::string column;  ///< of the sweep's table
};

/// A value whose unit another key decides: it is read when all keys are known.
struct Later {
  std::optional<Value> value;
};

}  // namespace salvo::scene
