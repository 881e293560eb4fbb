#include "scene/input_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "scene/csv_table.hpp"
#include "scene/nearest.hpp"

namespace salvo::scene {

namespace {

TableOpener hdf5_opener = nullptr;

bool names_hdf5(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& letter : ending) {
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  }
  return ending == ".hdf" || ending == ".h5" || ending == ".hdf5";
}

}  // namespace

void open_hdf5_tables_with(TableOpener opener) { hdf5_opener = opener; }

std::unique_ptr<InputTable> open_table(const std::string& path) {
  if (!names_hdf5(path)) return std::make_unique<CsvTable>(path);
  if (hdf5_opener == nullptr) {
    throw TableError(fmt::format("cannot read {}: this program reads no HDF5 files", path),
                     "expected a CSV file");
  }
  return hdf5_opener(path);
}

std::string_view without_mark(std::string_view text) {
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  if (text.starts_with(mark)) text.remove_prefix(mark.size());
  return text;
}

TableError no_such_column(const std::string& path, const std::string& what, const std::string& name,
                          std::span<const std::string> names) {
  const std::vector<std::string_view> known(names.begin(), names.end());
  std::string hint = did_you_mean(name, known);
  if (hint.empty()) {
    hint = known.empty() ? "it has none" : fmt::format("it has {}", fmt::join(known, ", "));
  }
  return {fmt::format("{} has no {} \"{}\"", path, what, name), hint};
}

}  // namespace salvo::scene
