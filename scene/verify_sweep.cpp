#include "scene/verify_sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "soa/value_at.hpp"

namespace salvo::scene {

namespace {

using solver::Execution;
using solver::Sweep;
using solver::SweepRows;

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
         (std::isnan(a) && std::isnan(b));
}

// The first row and column in which rows from `first` on differ from the reference's.
std::optional<SweepDifference> difference(const Sweep& sweep, const SweepRows& reference,
                                          const SweepRows& varied, std::uint64_t first) {
  for (std::size_t row = 0; row < varied.table.rows(); ++row) {
    for (std::size_t f = 0; f < sweep.fields().size(); ++f) {
      const double a = soa::value_at(reference.table, f, first + row);
      const double b = soa::value_at(varied.table, f, row);
      if (!same(a, b))
        return SweepDifference{first + row, std::string(sweep.fields()[f].name), a, b};
    }
    for (std::size_t level = 0; level < sweep.levels(); ++level) {
      const std::size_t in_reference = (first + row) * sweep.levels() + level;
      const std::size_t in_varied = row * sweep.levels() + level;
      if (!same(reference.sample_time[in_reference], varied.sample_time[in_varied])) {
        return SweepDifference{first + row, fmt::format("samples.time[{}]", level),
                               reference.sample_time[in_reference], varied.sample_time[in_varied]};
      }
      for (std::size_t f = 0; f < reference.samples.size(); ++f) {
        const double a = reference.samples[f][in_reference];
        const double b = varied.samples[f][in_varied];
        if (!same(a, b)) {
          return SweepDifference{
              first + row, fmt::format("samples.{}[{}]", sweep.sample_fields()[f].name, level), a,
              b};
        }
      }
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<SweepVerifyRun> verify(const SweepScene& scene, const SweepVerifyOptions& options) {
  const Sweep sweep(scene.setup);
  const std::uint64_t rows =
      std::min(sweep.rows(), options.rows != 0 ? options.rows : scene.verify_rows);
  const auto run = [&](std::uint64_t first, std::uint64_t count, const Execution& execution) {
    return options.run ? options.run(sweep, first, count, execution)
                       : sweep.run(first, count, execution);
  };
  std::vector<solver::Isa> isas = options.isas.empty() ? solver::available_isas() : options.isas;
  std::erase(isas, solver::Isa::scalar);
  const std::size_t count = 2 + isas.size() + options.threads.size() + options.chunks.size();
  std::vector<SweepVerifyRun> runs;
  const auto progress = [&] {
    if (options.on_progress) options.on_progress(runs.size(), count);
  };

  const Execution reference_execution{solver::Isa::scalar, 1, 1};
  const SweepRows reference = run(0, rows, reference_execution);
  const solver::Digest hash = reference.hash(solver::Parallel(1));
  runs.push_back({"reference", "scalar", hash, rows, std::nullopt});
  progress();
  const auto compare = [&](std::string axis, std::string value, const Execution& execution) {
    const SweepRows varied = run(0, rows, execution);
    SweepVerifyRun result{std::move(axis), std::move(value), varied.hash(solver::Parallel(1)), rows,
                          std::nullopt};
    if (!(result.hash == hash)) {
      result.difference = difference(sweep, reference, varied, 0);
      // Such as one in the sign of a zero of a column that is whole numbers here.
      if (!result.difference) result.difference = SweepDifference{0, "hash", 0, 0};
    }
    runs.push_back(std::move(result));
    progress();
  };
  for (const solver::Isa isa : isas) {
    compare("isa", std::string(name(isa)), {isa, 1, 1});
  }
  for (const int threads : options.threads) {
    compare("threads", fmt::to_string(threads), {solver::widest_isa(), threads, 1});
  }
  // Pieces have hashes of their own: their rows are compared, and the reference's hash stands for
  // them all.
  const auto compare_pieces = [&](std::string axis, std::string value, std::uint64_t piece,
                                  std::uint64_t stride) {
    SweepVerifyRun result{std::move(axis), std::move(value), hash, 0, std::nullopt};
    for (std::uint64_t first = 0; first < rows && !result.difference; first += stride) {
      const std::uint64_t length = std::min(piece, rows - first);
      const SweepRows varied = run(first, length, {solver::widest_isa(), 1, 1});
      result.difference = difference(sweep, reference, varied, first);
      result.rows += length;
    }
    runs.push_back(std::move(result));
    progress();
  };
  for (const std::uint64_t chunk : options.chunks) {
    compare_pieces("chunk", fmt::to_string(chunk), chunk, chunk);
  }
  const std::uint64_t alone = std::max<std::uint64_t>(1, rows / 32);
  compare_pieces("alone", fmt::format("every {}", alone), 1, alone);
  return runs;
}

}  // namespace salvo::scene
