// What a run's frames report of their particles, as tables for people.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "recording/frame.hpp"

namespace salvo::cli {

struct FrameLine {
  std::int64_t frame = 0;
  recording::StateInfo state;
};

/// At most a dozen frames, evenly spread, the first and the last among them; --json lists all.
std::string diagnostics_tables(const std::vector<FrameLine>& frames);

}  // namespace salvo::cli
