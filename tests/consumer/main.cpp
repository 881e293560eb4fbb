// A program of somebody else's: a thousand pendulums of its own model, on every instruction set of
// the machine, to one hash.
#include <cmath>
#include <cstdio>

#include "pendulum.hpp"

int main() {
  using namespace salvo;
  std::printf("salvo %s\n", SALVO_FOUND_VERSION);
  constexpr std::size_t rows = 1001;
  std::string first;
  for (const solver::Isa isa : solver::available_isas()) {
    solver::Batch batch(&pendulum_kernels, soa::Precision::float64, rows);
    const auto angle = batch.column<double>("angle");
    const auto length = batch.column<double>("length");
    for (std::size_t i = 0; i < rows; ++i) {
      angle[i] = 1e-3;
      length[i] = 1 + static_cast<double>(i) / 256;
    }
    batch.advance(1000, 1e-3, isa);
    const std::string hash = to_string(batch.hash().total);
    std::printf("%-6s %s\n", std::string(name(isa)).c_str(), hash.c_str());
    if (first.empty()) first = hash;
    if (hash != first) return 1;
    // Small swings: theta = theta0 cos(sqrt(g / l) t), here after one second.
    for (std::size_t i = 0; i < rows; ++i) {
      const double exact = 1e-3 * std::cos(std::sqrt(9.80665 / length[i]));
      if (std::abs(angle[i] - exact) > 1e-9) return 1;
    }
  }
  return 0;
}
