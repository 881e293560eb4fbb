// clang-format off
// The names of the files of a recording.
//
//   frame_000012.hdf          the 12th frame
//   checkpoint_000000123.hdf  the full state at step 123
//   rows_000003.hdf          rows 3 * 65,536 and after of a sweep
//   trajectories.hdf         all rows of a sweep, as one file
//   statistics.json          what is told of all rows together
//   frames.hdf.series         the frames' times, for ParaView
//   run.json                  how the run was made
// clang-format on
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace salvo::recording {

inline constexpr const char* series_name = "frames.hdf.series";
inline constexpr const char* run_name = "run.json";
inline constexpr const char* trajectories_name = "trajectories.hdf";
inline constexpr const char* statistics_name = "statistics.json";

std::string frame_name(std::int64_t frame);
std::string checkpoint_name(std::int64_t step);
std::string part_name(std::int64_t part);

struct NumberedFile {
  std::int64_t number = 0;  ///< of the frame or part, or the step of the checkpoint
  std::filesystem::path path;
};

/// By ascending number. Empty when the directory is missing.
std::vector<NumberedFile> list_frames(const std::filesystem::path& directory);
std::vector<NumberedFile> list_checkpoints(const std::filesystem::path& directory);
std::vector<NumberedFile> list_parts(const std::filesystem::path& directory);

/// All files in the directory whose names are a recording's; not those that are partly written.
std::vector<std::filesystem::path> recording_files(const std::filesystem::path& directory);

/// Removes what a killed run left half-written. Throws OutputError.
void remove_partial_files(const std::filesystem::path& directory);

}  // namespace salvo::recording
