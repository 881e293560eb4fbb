// One file of a sweep's rows: Sweep::part_rows of them, fewer in the last. A field "end.x" is the
// dataset /end/x; samples are /samples/NAME[row, level], at the levels /samples/level.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "recording/errors.hpp"
#include "recording/frame.hpp"
#include "scene/sweep_scene.hpp"

namespace salvo::recording {

/// What the attributes of a part say.
struct PartInfo {
  std::uint64_t first = 0;  ///< index of its first row
  std::uint64_t rows = 0;
  solver::Digest row_digest;  ///< scene::row_digest of the scene
  solver::Digest hash;        ///< of its rows
  soa::Precision precision = soa::Precision::float64;
  std::vector<std::string> columns;   ///< names of the fields, in order
  std::vector<std::string> outcomes;  ///< what the values of the column "outcome" mean
  std::string scene_path;
  std::string scene_text;
  std::vector<std::string> overrides;
};

/// Throws OutputError.
void write_part(const std::filesystem::path& path, const scene::SweepScene& scene,
                const solver::Sweep& sweep, const solver::SweepRows& rows,
                const solver::Digest& hash);

/// Throws CorruptFile, as all that read do.
PartInfo read_part_info(const std::filesystem::path& path);

/// The named columns of a part as numbers, and its outcomes.
struct PartColumns {
  std::vector<std::vector<double>> values;
  std::vector<std::uint32_t> outcome;
};
PartColumns read_part_columns(const std::filesystem::path& path,
                              const std::vector<std::string>& names);

/// All columns, for the exports of frames; outcomes by their names.
struct PartRows {
  PartInfo info;
  Frame frame;
};
PartRows read_part(const std::filesystem::path& path);

/// "/end/x" for "end.x".
std::string dataset_path(std::string_view field);

}  // namespace salvo::recording
