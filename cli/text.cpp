#include "cli/text.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace salvo::cli {

namespace {

// Three digits and the letter of the power of 1000.
std::string scaled(double number, const char* letters) {
  std::size_t power = 0;
  while (number >= 999.5 && letters[power + 1] != '\0') {
    number /= 1000;
    ++power;
  }
  const int decimals = power == 0 || number >= 99.95 ? 0 : number >= 9.995 ? 1 : 2;
  std::string text = fmt::format("{:.{}f} ", number, decimals);
  if (letters[power] != ' ') text += letters[power];
  return text;
}

}  // namespace

std::string grouped(std::uint64_t number) {
  std::string text = fmt::to_string(number);
  for (std::size_t from_end = 3; from_end < text.size(); from_end += 4) {
    text.insert(text.size() - from_end, 1, ',');
  }
  return text;
}

std::string bytes_text(std::uint64_t bytes) {
  return scaled(static_cast<double>(bytes), " kMGTPE") + "B";
}

std::string seconds_text(double seconds) {
  if (!(seconds >= 0) || seconds > 1e9) return "?";
  if (seconds < 9.995) return fmt::format("{:.2f} s", seconds);
  if (seconds < 59.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::uint64_t>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

std::string rate_text(double particle_steps_per_second) {
  if (!std::isfinite(particle_steps_per_second)) return "? particle-steps/s";
  const std::string number = scaled(particle_steps_per_second, " kMGTPE");
  return number + (number.back() == ' ' ? "" : " ") + "particle-steps/s";
}

std::string counted(std::uint64_t number, const char* noun) {
  std::string word = noun;
  if (number != 1 && word.ends_with('y')) {
    word.replace(word.size() - 1, 1, "ies");
  } else if (number != 1) {
    word += 's';
  }
  return fmt::format("{} {}", grouped(number), word);
}

}  // namespace salvo::cli
