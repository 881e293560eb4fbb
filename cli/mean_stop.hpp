// [stop]: a sweep ends when the mean of a column is known well enough.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scene/sweep_scene.hpp"

namespace salvo::cli {

class MeanStop {
 public:
  /// Of a scene that has a [stop].
  explicit MeanStop(const scene::SweepScene& scene) : scene_(scene) {}

  /// The column in the next part, of the rows that count; or the part's rows, all of them.
  void add_part(std::span<const std::vector<double>> columns);
  void add_part(const solver::Sweep& sweep, const solver::SweepRows& rows);

  bool reached() const { return reached_; }
  /// Of the confidence interval of the mean over the parts so far.
  double half_width() const { return half_width_; }

 private:
  const scene::SweepScene& scene_;
  solver::Moments moments_{1};
  double half_width_ = 0;
  bool reached_ = false;
};

}  // namespace salvo::cli
