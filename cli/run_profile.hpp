// Where the time of a run of particles went, for people and for programs.
#pragma once

#include <string>

#include "cli/json.hpp"
#include "solver/world.hpp"

namespace salvo::cli {

struct RunProfile {
  double stepping = 0;   ///< s
  double recording = 0;  ///< s, without what the writing thread does meanwhile
  double waiting = 0;    ///< s of it, for that thread
  const solver::World& world;
};

std::string profile_text(const RunProfile& profile);
Json profile_document(const RunProfile& profile);

}  // namespace salvo::cli
