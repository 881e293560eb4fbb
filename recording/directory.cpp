#include "recording/directory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

#include "recording/output_file.hpp"

namespace salvo::recording {

namespace {

constexpr std::string_view frame_prefix = "frame_";
constexpr std::string_view checkpoint_prefix = "checkpoint_";
constexpr std::string_view part_prefix = "rows_";
constexpr std::string_view extension = ".hdf";  // the only one that ParaView's reader takes

// The number in PREFIX<digits>.hdf, if the name is exactly what we would call that number.
template <class Name>
std::optional<std::int64_t> number_in(std::string_view file, std::string_view prefix, Name name) {
  if (!file.starts_with(prefix) || !file.ends_with(extension)) return std::nullopt;
  const std::string_view digits =
      file.substr(prefix.size(), file.size() - prefix.size() - extension.size());
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size() || number < 0) {
    return std::nullopt;
  }
  return name(number) == file ? std::optional(number) : std::nullopt;
}

std::optional<std::int64_t> frame_number(std::string_view file) {
  return number_in(file, frame_prefix, frame_name);
}
std::optional<std::int64_t> checkpoint_step(std::string_view file) {
  return number_in(file, checkpoint_prefix, checkpoint_name);
}

std::optional<std::int64_t> part_number(std::string_view file) {
  return number_in(file, part_prefix, part_name);
}

bool is_recording_name(std::string_view file) {
  return file == series_name || file == run_name || file == trajectories_name ||
         file == statistics_name || frame_number(file) || checkpoint_step(file) ||
         part_number(file);
}

std::optional<std::string_view> partial_of(std::string_view file) {
  constexpr std::string_view suffix = ".partial";
  if (!file.starts_with('.') || !file.ends_with(suffix)) return std::nullopt;
  file.remove_prefix(1);
  file.remove_suffix(suffix.size());
  return file;
}

std::vector<std::filesystem::path> files_in(const std::filesystem::path& directory) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(directory, error)) {
    if (!entry.is_directory(error)) files.push_back(entry.path());
  }
  std::stable_sort(files.begin(), files.end());
  return files;
}

template <class Number>
std::vector<NumberedFile> list(const std::filesystem::path& directory, Number number_of) {
  std::vector<NumberedFile> files;
  for (const std::filesystem::path& path : files_in(directory)) {
    if (const auto number = number_of(path.filename().string())) files.push_back({*number, path});
  }
  std::stable_sort(files.begin(), files.end(), [](const NumberedFile& a, const NumberedFile& b) {
    return a.number < b.number;
  });
  return files;
}

}  // namespace

std::string frame_name(std::int64_t frame) {
  return fmt::format("{}{:06}{}", frame_prefix, frame, extension);
}

std::string checkpoint_name(std::int64_t step) {
  return fmt::format("{}{:09}{}", checkpoint_prefix, step, extension);
}

std::string part_name(std::int64_t part) {
  return fmt::format("{}{:06}{}", part_prefix, part, extension);
}

std::vector<NumberedFile> list_parts(const std::filesystem::path& directory) {
  return list(directory, part_number);
}

std::vector<NumberedFile> list_frames(const std::filesystem::path& directory) {
  return list(directory, frame_number);
}

std::vector<NumberedFile> list_checkpoints(const std::filesystem::path& directory) {
  return list(directory, checkpoint_step);
}

std::vector<std::filesystem::path> recording_files(const std::filesystem::path& directory) {
  std::vector<std::filesystem::path> files = files_in(directory);
  std::erase_if(files, [](const std::filesystem::path& path) {
    return !is_recording_name(path.filename().string());
  });
  return files;
}

void remove_partial_files(const std::filesystem::path& directory) {
  for (const std::filesystem::path& path : files_in(directory)) {
    const std::string file = path.filename().string();
    const auto target = partial_of(file);
    if (target && is_recording_name(*target)) remove_file(path);
  }
}

}  // namespace salvo::recording
