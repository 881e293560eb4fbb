#include "scene/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "scene/nearest.hpp"

namespace salvo::scene {

namespace {

// A natural number of any size: just enough arithmetic to divide two of them and round once.
class Natural {
 public:
  explicit Natural(std::uint32_t value = 0) {
    if (value != 0) words_.push_back(value);
  }
  bool zero() const { return words_.empty(); }
  int bits() const {
    return zero() ? 0 : static_cast<int>(words_.size() * 32) - std::countl_zero(words_.back());
  }
  void multiply_add(std::uint32_t factor, std::uint32_t summand) {
    std::uint64_t carry = summand;
    for (std::uint32_t& word : words_) {
      carry += std::uint64_t{word} * factor;
      word = static_cast<std::uint32_t>(carry);
      carry >>= 32;
    }
    if (carry != 0) words_.push_back(static_cast<std::uint32_t>(carry));
  }
  void scale_by_power_of_ten(int power) {
    for (int i = 0; i < power; ++i) multiply_add(10, 0);
  }
  void shift_left(int bits) {
    words_.insert(words_.begin(), static_cast<std::size_t>(bits / 32), 0);
    if (bits % 32 != 0) multiply_add(std::uint32_t{1} << bits % 32, 0);
  }
  // Only for other <= *this.
  void subtract(const Natural& other) {
    std::uint64_t borrow = 0;
    for (std::size_t i = 0; i < words_.size(); ++i) {
      const std::uint64_t taken = borrow + (i < other.words_.size() ? other.words_[i] : 0);
      borrow = words_[i] < taken ? 1 : 0;
      words_[i] = static_cast<std::uint32_t>((borrow << 32) + words_[i] - taken);
    }
    while (!words_.empty() && words_.back() == 0) words_.pop_back();
  }
  friend bool operator<(const Natural& a, const Natural& b) {
    if (a.words_.size() != b.words_.size()) return a.words_.size() < b.words_.size();
    return std::lexicographical_compare(a.words_.rbegin(), a.words_.rend(), b.words_.rbegin(),
                                        b.words_.rend());
  }
  friend Natural operator*(const Natural& a, const Natural& b) {
    Natural product;
    for (auto word = b.words_.rbegin(); word != b.words_.rend(); ++word) {
      product.shift_left(32);
      Natural part = a;
      part.multiply_add(*word, 0);
      product.add(part);
    }
    return product;
  }

 private:
  void add(const Natural& other) {
    words_.resize(std::max(words_.size(), other.words_.size()));
    std::uint64_t carry = 0;
    for (std::size_t i = 0; i < words_.size(); ++i) {
      carry += std::uint64_t{words_[i]} + (i < other.words_.size() ? other.words_[i] : 0);
      words_[i] = static_cast<std::uint32_t>(carry);
      carry >>= 32;
    }
    if (carry != 0) words_.push_back(static_cast<std::uint32_t>(carry));
    while (!words_.empty() && words_.back() == 0) words_.pop_back();
  }

  std::vector<std::uint32_t> words_;  // least significant first, no leading zero
};

// The double nearest to above / below, ties to even; infinite when that is beyond the largest.
double nearest_double(Natural above, Natural below) {
  if (above.zero()) return 0;
  // A quotient of 64 or 65 bits, its last bit set when anything is left over.
  int exponent = above.bits() - below.bits() - 64;
  if (exponent < 0) {
    above.shift_left(-exponent);
  } else {
    below.shift_left(exponent);
  }
  std::uint64_t quotient = 0;
  int lost = 0;
  Natural divisor = below;
  divisor.shift_left(64);
  for (int bit = 64; bit >= 0; --bit) {
    const bool taken = !(above < divisor);
    if (taken) above.subtract(divisor);
    if (bit == 0 && (quotient >> 63) != 0) {  // the 65th bit goes into the sticky one
      lost = taken ? 1 : 0;
      exponent += 1;
    } else {
      quotient = quotient << 1 | (taken ? 1U : 0U);
    }
    above.shift_left(1);
  }
  const bool sticky = lost != 0 || !above.zero();
  // The last place of the result: 53 bits, fewer among the subnormal numbers.
  const int top = 64 - std::countl_zero(quotient) + exponent;  // quotient 2^exponent < 2^top
  const int last = std::max(top - 53, -1074);
  const int drop = last - exponent;
  if (drop > 64) return 0;
  std::uint64_t kept = drop == 64 ? 0 : quotient >> drop;
  const std::uint64_t half = std::uint64_t{1} << (drop - 1);
  const std::uint64_t rest = drop == 64 ? quotient : quotient & ((half << 1) - 1);
  if (rest > half || (rest == half && (sticky || (kept & 1) != 0))) ++kept;
  if (last > 971 || (last == 971 && kept == std::uint64_t{1} << 53)) return HUGE_VAL;
  return std::ldexp(static_cast<double>(kept), last);
}

// digits 10^exponent
struct Decimal {
  Natural digits;
  int exponent = 0;
};

constexpr int longest_exponent = 5000;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Reads an unsigned decimal number at the start of `text` and removes it from there; false when
// there is none.
bool take_decimal(std::string_view& text, Decimal& decimal) {
  std::size_t at = 0;
  bool any = false;
  bool after_point = false;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (is_digit(c)) {
      decimal.digits.multiply_add(10, static_cast<std::uint32_t>(c - '0'));
      decimal.exponent -= after_point ? 1 : 0;
      any = true;
    } else if (c == '.' && !after_point) {
      after_point = true;
    } else if (c != '_' || !any) {
      break;
    }
  }
  if (!any) return false;
  std::size_t mark = at;
  if (mark < text.size() && (text[mark] == 'e' || text[mark] == 'E')) {
    ++mark;
    const bool negative = mark < text.size() && text[mark] == '-';
    if (mark < text.size() && (text[mark] == '-' || text[mark] == '+')) ++mark;
    int exponent = 0;
    const std::size_t first = mark;
    for (; mark < text.size() && is_digit(text[mark]); ++mark) {
      exponent = std::min(exponent * 10 + (text[mark] - '0'), longest_exponent);
    }
    if (mark != first) {  // else the e belongs to the unit
      decimal.exponent += negative ? -exponent : exponent;
      at = mark;
    }
  }
  text.remove_prefix(at);
  return true;
}

// Powers of length, mass, time and angle.
using Dimension = std::array<int, 4>;

struct Unit {
  std::string_view symbol;
  std::string_view meaning;
  Dimension dimension;
  std::string_view factor;  // SI units in one of these, over `divisor`
  std::string_view divisor = "1";
};

constexpr Dimension length{1, 0, 0, 0}, mass{0, 1, 0, 0}, duration{0, 0, 1, 0}, angle{0, 0, 0, 1};
constexpr Dimension speed{1, 0, -1, 0}, force{1, 1, -2, 0}, energy{2, 1, -2, 0};
constexpr Dimension pressure{-1, 1, -2, 0}, pure{0, 0, 0, 0};
constexpr std::string_view pi_digits =
    "3.14159265358979323846264338327950288419716939937510582097494";
constexpr std::string_view two_pi_digits =
    "6.28318530717958647692528676655900576839433879875021164194989";

constexpr std::array units = std::to_array<Unit>({
    {"m", "metre", length, "1"},
    {"km", "kilometre", length, "1000"},
    {"cm", "centimetre", length, "0.01"},
    {"mm", "millimetre", length, "0.001"},
    {"um", "micrometre", length, "0.000001"},
    {"in", "inch", length, "0.0254"},
    {"ft", "foot", length, "0.3048"},
    {"yd", "yard", length, "0.9144"},
    {"mi", "mile", length, "1609.344"},
    {"nmi", "nautical mile", length, "1852"},
    {"kg", "kilogram", mass, "1"},
    {"g", "gram", mass, "0.001"},
    {"mg", "milligram", mass, "0.000001"},
    {"t", "tonne", mass, "1000"},
    {"lb", "pound", mass, "0.45359237"},
    {"oz", "ounce", mass, "0.028349523125"},
    {"gr", "grain", mass, "0.00006479891"},
    {"slug", "slug", mass, "4.4482216152605", "0.3048"},
    {"s", "second", duration, "1"},
    {"ms", "millisecond", duration, "0.001"},
    {"us", "microsecond", duration, "0.000001"},
    {"min", "minute", duration, "60"},
    {"h", "hour", duration, "3600"},
    {"rad", "radian", angle, "1"},
    {"mrad", "milliradian", angle, "0.001"},
    {"deg", "degree", angle, pi_digits, "180"},
    {"arcmin", "minute of arc", angle, pi_digits, "10800"},
    {"arcsec", "second of arc", angle, pi_digits, "648000"},
    {"rev", "revolution", angle, two_pi_digits},
    {"fps", "foot a second", speed, "0.3048"},
    {"mph", "mile an hour", speed, "0.44704"},
    {"kn", "knot", speed, "1852", "3600"},
    {"Hz", "hertz", {0, 0, -1, 0}, "1"},
    {"N", "newton", force, "1"},
    {"kN", "kilonewton", force, "1000"},
    {"MN", "meganewton", force, "1000000"},
    {"lbf", "pound-force", force, "4.4482216152605"},
    {"J", "joule", energy, "1"},
    {"kJ", "kilojoule", energy, "1000"},
    {"MJ", "megajoule", energy, "1000000"},
    {"TNT", "energy in a mass of TNT: \"1 kg TNT\"", {2, 0, -2, 0}, "4184000"},
    {"Pa", "pascal", pressure, "1"},
    {"hPa", "hectopascal", pressure, "100"},
    {"kPa", "kilopascal", pressure, "1000"},
    {"MPa", "megapascal", pressure, "1000000"},
    {"GPa", "gigapascal", pressure, "1000000000"},
    {"bar", "bar", pressure, "100000"},
    {"%", "per cent", pure, "0.01"},
    {"1", "one, as in \"1/s\"", pure, "1"},
});

struct DimensionName {
  Dimension dimension;
  std::string_view name;
};

constexpr std::array dimension_names = std::to_array<DimensionName>({
    {pure, "a pure number"},
    {length, "a length"},
    {{2, 0, 0, 0}, "an area"},
    {{3, 0, 0, 0}, "a volume"},
    {mass, "a mass"},
    {duration, "a time"},
    {angle, "an angle"},
    {{0, 0, -1, 0}, "a rate"},
    {{0, 0, -1, 1}, "an angular velocity"},
    {speed, "a speed"},
    {{1, 0, -2, 0}, "an acceleration"},
    {force, "a force"},
    {{0, 1, -2, 0}, "a force per length"},
    {energy, "an energy"},
    {{1, 1, -1, 0}, "an impulse"},
    {{-3, 1, 0, 0}, "a density"},
    {{0, 1, -1, 0}, "a force per speed"},
    {{3, 0, -2, 0}, "a gravitational parameter"},
    {pressure, "a pressure"},
    {{2, 0, -2, 0}, "an energy per mass"},
});

std::string_view name_of(const Dimension& dimension) {
  const auto found =
      std::find_if(dimension_names.begin(), dimension_names.end(),
                   [&](const DimensionName& entry) { return entry.dimension == dimension; });
  return found == dimension_names.end() ? "another kind of quantity" : found->name;
}

// A product of units: SI units in one of it, as above / below 10^exponent.
struct Scale {
  Natural above{1};
  Natural below{1};
  int exponent = 0;
  Dimension dimension{};

  void multiply(const Unit& unit, int power) {
    for (std::size_t d = 0; d < dimension.size(); ++d) dimension[d] += power * unit.dimension[d];
    for (int i = 0; i < std::abs(power); ++i) {
      times(unit.factor, power > 0);
      times(unit.divisor, power < 0);
    }
  }

 private:
  void times(std::string_view number, bool over) {
    Decimal decimal;
    take_decimal(number, decimal);
    Natural& side = over ? above : below;
    side = side * decimal.digits;
    exponent += over ? decimal.exponent : -decimal.exponent;
  }
};

// Signs that people type for what the table spells in ASCII.
std::string plain(std::string_view text) {
  static constexpr std::pair<std::string_view, std::string_view> signs[] = {
      {"²", "^2"}, {"³", "^3"}, {"°", "deg"}, {"µ", "u"}, {"μ", "u"}, {"·", " "}, {"*", " "}};
  std::string out(text);
  for (const auto& [sign, spelling] : signs) {
    for (std::size_t at; (at = out.find(sign)) != std::string::npos;) {
      out.replace(at, sign.size(), spelling);
    }
  }
  return out;
}

[[noreturn]] void refuse_symbol(std::string_view symbol, std::string_view wanted) {
  std::vector<std::string_view> symbols;
  symbols.reserve(units.size());
  for (const Unit& unit : units) symbols.push_back(unit.symbol);
  const std::string near = did_you_mean(symbol, symbols);
  throw UnitError(fmt::format("unknown unit \"{}\"", symbol),
                  !near.empty()    ? near
                  : wanted.empty() ? "expected a pure number"
                                   : fmt::format("expected a number in {}", wanted));
}

[[noreturn]] void refuse_slash(std::string_view written) {
  throw UnitError(fmt::format("\"{}\" is no unit", written), "one unit follows each /");
}

Scale scale_of(std::string_view written, std::string_view wanted) {
  const std::string text = plain(written);
  Scale scale;
  int sign = 1;
  for (std::size_t at = 0; at < text.size();) {
    if (text[at] == ' ' || text[at] == '/') {
      if (text[at] == '/' && sign < 0) refuse_slash(written);
      if (text[at] == '/') sign = -1;
      ++at;
      continue;
    }
    std::size_t end = at;
    while (end < text.size() && text[end] != ' ' && text[end] != '/' && text[end] != '^' &&
           (end == at || !is_digit(text[end]))) {
      ++end;
    }
    const std::string_view symbol = std::string_view(text).substr(at, end - at);
    const auto unit = std::find_if(units.begin(), units.end(),
                                   [&](const Unit& entry) { return entry.symbol == symbol; });
    if (unit == units.end()) refuse_symbol(symbol, wanted);
    int power = 1;
    if (end < text.size() && (text[end] == '^' || is_digit(text[end]))) {  // m^3, or m3
      end += text[end] == '^' ? 1 : 0;
      const bool negative = end < text.size() && text[end] == '-';
      end += negative ? 1 : 0;
      if (end >= text.size() || text[end] < '1' || text[end] > '9') {
        throw UnitError(fmt::format("\"{}\" is no unit", written), "a power is ^1 to ^9");
      }
      power = (negative ? -1 : 1) * (text[end] - '0');
      ++end;
    }
    scale.multiply(*unit, sign * power);
    sign = 1;
    at = end;
  }
  if (sign < 0) refuse_slash(written);
  return scale;
}

double converted(bool negative, const Decimal& number, const Scale& from, const Scale& to) {
  Natural above = number.digits * from.above * to.below;
  Natural below = from.below * to.above;
  const int exponent = number.exponent + from.exponent - to.exponent;
  // Far beyond every double, and too long to write out.
  if (exponent > longest_exponent && !above.zero()) {
    return negative ? -HUGE_VAL : HUGE_VAL;
  }
  if (exponent < -2 * longest_exponent) return negative ? -0.0 : 0.0;
  above.scale_by_power_of_ten(std::max(exponent, 0));
  below.scale_by_power_of_ten(std::max(-exponent, 0));
  const double magnitude = nearest_double(std::move(above), std::move(below));
  return negative ? -magnitude : magnitude;
}

bool take_sign(std::string_view& text) {
  const bool negative = !text.empty() && text.front() == '-';
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) text.remove_prefix(1);
  return negative;
}

std::string example(std::string_view unit) {
  return unit.empty() ? "expected a number without a unit"
                      : fmt::format("expected {} in {}", dimension_name(unit), unit);
}

}  // namespace

double quantity(std::string_view text, std::string_view unit) {
  const std::string_view written = text;
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  const bool negative = take_sign(text);
  Decimal number;
  if (!take_decimal(text, number)) {
    throw UnitError(fmt::format("\"{}\" does not start with a number", written), example(unit));
  }
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  const Scale to = scale_of(unit, unit);
  const Scale from = scale_of(text, unit);
  if (from.dimension != to.dimension) {
    throw UnitError(text.empty() ? fmt::format("\"{}\" has no unit", written)
                                 : fmt::format("\"{}\" is {}", written, name_of(from.dimension)),
                    example(unit));
  }
  const double value = converted(negative, number, from, to);
  if (!std::isfinite(value)) {
    throw UnitError(fmt::format("\"{}\" is too large", written), example(unit));
  }
  return value;
}

double number_in(std::string_view number, std::string_view unit) {
  const std::string_view written = number;
  const bool negative = take_sign(number);
  Decimal decimal;
  if (!take_decimal(number, decimal) || !number.empty()) {
    throw UnitError(fmt::format("{} is not a finite number", written), example(unit));
  }
  const double value = converted(negative, decimal, Scale(), scale_of(unit, unit));
  if (!std::isfinite(value)) {
    throw UnitError(fmt::format("{} is too large", written), example(unit));
  }
  return value;
}

std::string dimension_name(std::string_view unit) {
  return std::string(name_of(scale_of(unit, unit).dimension));
}

std::string unit_reference() {
  std::string text = "| unit | name | is |\n|---|---|---|\n";
  for (const Unit& unit : units) {
    text += fmt::format("| `{}` | {} | {} |\n", unit.symbol, unit.meaning, name_of(unit.dimension));
  }
  return text;
}

}  // namespace salvo::scene
