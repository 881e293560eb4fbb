// Numbers with units: "2700 fps", "168 gr", "10 deg", "1 kg TNT". The factors are exact ratios and
// the product is rounded once, so the unit never changes the result: "100 cm" is the same double
// as 1.0, whatever compiler, C library or rounding mode of the caller.
//
// A unit is symbols joined by spaces (or *) and /, each with an optional whole power: "kg/m^3", "N
// s", "m^3/s^2". Each / divides by the one symbol after it.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace salvo::scene {

/// A text that is no quantity of the wanted unit: what() says what is wrong, hint() what to do.
class UnitError : public std::runtime_error {
 public:
  UnitError(const std::string& problem, std::string hint)
      : std::runtime_error(problem), hint_(std::move(hint)) {}
  const std::string& hint() const { return hint_; }

 private:
  std::string hint_;
};

/// The number and unit in `text`, as a multiple of `unit`, rounded to the nearest double (ties to
/// even). "" is the unit of a pure number. Throws UnitError.
double quantity(std::string_view text, std::string_view unit);

/// The decimal number `number`, given in the coherent SI unit of `unit`'s dimension, as a multiple
/// of `unit`: equals the number itself when `unit` is SI.
double number_in(std::string_view number, std::string_view unit);

/// What a unit measures, with its article: "a speed", "a density"; "a pure number" for "".
std::string dimension_name(std::string_view unit);

/// Every symbol that a unit may be made of, as Markdown.
std::string unit_reference();

}  // namespace salvo::scene
