#include "cli/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "cli/terminal.hpp"
#include "cli/text.hpp"

namespace salvo::cli {

namespace {

constexpr auto redraw_interval = std::chrono::milliseconds(100);
constexpr auto line_interval = std::chrono::seconds(10);

double seconds_between(Progress::Clock::time_point from, Progress::Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

Progress::Progress(bool quiet)
    : quiet_(quiet), redraws_(stderr_is_terminal()), start_(Clock::now()), last_(start_) {}

Progress::~Progress() { clear(); }

double Progress::seconds() const { return seconds_between(start_, Clock::now()); }

void Progress::update(double fraction, const std::function<std::string()>& detail) {
  if (quiet_) return;
  const auto now = Clock::now();
  if (now - last_ < (redraws_ ? Clock::duration(redraw_interval) : line_interval)) return;
  last_ = now;
  // Rounded down, so that 100 % means done.
  std::string line = fmt::format("{:3} %  {}", static_cast<int>(fraction * 100), detail());
  if (fraction > 0) {
    const double left = seconds_between(start_, now) * (1 - fraction) / fraction;
    line += fmt::format("  {} left", seconds_text(left));
  }
  if (!redraws_) {
    say(line);
    return;
  }
  line.resize(std::min(line.size(), terminal_columns() - 1));
  fmt::print(stderr, "\r{}\033[K", line);
  std::fflush(stderr);
  drawn_ = true;
}

void Progress::clear() {
  if (!drawn_) return;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
  drawn_ = false;
}

}  // namespace salvo::cli
