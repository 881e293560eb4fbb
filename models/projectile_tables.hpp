// The tables behind models/projectile.hpp: drag functions, the standard ones and a user's own, and
// the standard atmosphere by cubics over 200 m of geopotential height.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "models/drag_functions.hpp"
#include "models/model_data.hpp"
#include "soa/cubic_table.hpp"

namespace salvo::models {

template <class T>
struct ProjectileTables {
  /// All drag functions, one after another on the same Mach numbers, from 0; outside its own
  /// numbers a function holds its first or last value. Behind the standard ones is the user's own,
  /// NaN where there is none.
  soa::CubicTable<T> drag;
  soa::CubicTable<T> drag_place;  // the intervals of one function
  std::size_t drag_stride = 0;    // coefficients of one function
  soa::CubicTable<T> density;     // kg/m^3, against geopotential height
  soa::CubicTable<T> slowness;    // one over the speed of sound, s/m, on the same heights
};

enum class DragInterpolation {
  monotone,  ///< a cubic between each two points, without overshoot, with a continuous slope
  linear
};

/// The drag functions of a batch.
class DragTables : public ModelData {
 public:
  /// The Mach numbers of an own function are from 0 to this, to four decimals.
  static constexpr double most_mach = 20;

  /// `own` may be empty. Throws std::invalid_argument with mistake_in(own).
  DragTables(std::span<const DragPoint> own, DragInterpolation interpolation);
  ~DragTables() override;

  std::span<const double> numbers() const override { return numbers_; }
  template <class T>
  const ProjectileTables<T>& of() const;

  struct Mistake {
    std::size_t point;
    std::string problem;
    std::string hint;
  };
  /// What is wrong with an own function.
  static std::optional<Mistake> mistake_in(std::span<const DragPoint> own);

 private:
  std::vector<double> numbers_;
  ProjectileTables<float> float32_;
  ProjectileTables<double> float64_;
};

template <>
const ProjectileTables<float>& DragTables::of() const;
template <>
const ProjectileTables<double>& DragTables::of() const;

/// The standard drag functions alone, by monotone cubics. Made once, at the first call.
template <class T>
const ProjectileTables<T>& projectile_tables();

extern template const ProjectileTables<float>& projectile_tables();
extern template const ProjectileTables<double>& projectile_tables();

}  // namespace salvo::models
