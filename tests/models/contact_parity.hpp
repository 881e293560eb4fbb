// Contact behind plain function pointers, for each instruction set. Columns are 64-byte aligned and
// their length is a multiple of 64.
#pragma once

#include <cstddef>
#include <span>

#include "models/obstacle.hpp"

namespace salvo::tests::contact_parity {

/// Position and velocity, x y z each.
template <class T>
struct Columns {
  T* state[6];
};

template <class T>
struct Run {
  std::span<const models::Obstacle> obstacles;
  models::ContactSettings settings;
  T dt = 0;
  T gravity = 0;  // along -y
  int steps = 1;
  std::size_t rows = 0;
  const T* mass = nullptr;
  const T* radius = nullptr;
  const T* active = nullptr;  // 0: the lane is not active
  Columns<T> before;
  /// Null: free fall from `before`, `steps` times. Otherwise the ends of one step of any kind.
  const Columns<T>* after = nullptr;
  Columns<T> result;
  T* impacts = nullptr;
  T* rests = nullptr;
};

struct Table {
  void (*single)(const Run<float>&);
  void (*twice)(const Run<double>&);
};

}  // namespace salvo::tests::contact_parity
