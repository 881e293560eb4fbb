// Numbers as people read them.
#pragma once

#include <cstdint>
#include <string>

namespace salvo::cli {

std::string grouped(std::uint64_t number);                ///< "1,000,000"
std::string bytes_text(std::uint64_t bytes);              ///< "12.3 MB"
std::string seconds_text(double seconds);                 ///< "0.42 s", "1 min 12 s", "3 h 20 min"
std::string rate_text(double particle_steps_per_second);  ///< "152 M particle-steps/s"
/// "1 frame", "2 frames", "1,000 particles"
std::string counted(std::uint64_t number, const char* noun);

}  // namespace salvo::cli
