// How far a run is, on stderr: one line that is redrawn on a terminal, a line every ten seconds
// elsewhere, nothing when quiet.
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace salvo::cli {

class Progress {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Progress(bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `fraction` of the work is done; `detail` is only asked for when it is shown, after percent and
  /// before the time left.
  void update(double fraction, const std::function<std::string()>& detail);
  /// Takes the line off the terminal, before something else is printed.
  void clear();
  double seconds() const;

 private:
  const bool quiet_;
  const bool redraws_;
  const Clock::time_point start_;
  Clock::time_point last_;
  bool drawn_ = false;
};

}  // namespace salvo::cli
