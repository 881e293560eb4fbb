#include "recording/hdf5_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "recording/hdf5.hpp"
#include "recording/sealed_file.hpp"
#include "scene/units.hpp"

namespace salvo::recording {

namespace {

using hdf5::checked;
using hdf5::Handle;
using scene::TableError;

bool is_number(hid_t type) {
  const H5T_class_t kind = H5Tget_class(type);
  return kind == H5T_INTEGER || kind == H5T_FLOAT;
}

// Datasets that a column may be, by their paths. Links that lead nowhere are none.
std::vector<std::string> columns_in(hid_t file) {
  std::vector<std::string> names;
  const auto add = [](hid_t group, const char* name, const H5L_info_t*, void* data) -> herr_t {
    const hid_t id = H5Dopen2(group, name, H5P_DEFAULT);
    if (id < 0) return 0;
    try {
      const Handle dataset(id, "open a dataset");
      if (hdf5::extents_of(dataset).size() == 1 && is_number(hdf5::type_of_dataset(dataset))) {
        static_cast<std::vector<std::string>*>(data)->emplace_back(name);
      }
    } catch (const std::exception&) {  // must not pass through HDF5's frames
      return -1;
    }
    return 0;
  };
  checked(H5Lvisit(file, H5_INDEX_NAME, H5_ITER_INC, add, &names), "list the datasets");
  return names;
}

class Hdf5Table : public scene::InputTable {
 public:
  explicit Hdf5Table(std::string path) : path_(std::move(path)) {
    errno = 0;
    if (!std::ifstream(path_)) {
      throw TableError(fmt::format("cannot read {}: {}", path_,
                                   std::generic_category().message(errno != 0 ? errno : ENOENT)),
                       "its path is relative to the scene's");
    }
    const hdf5::Session session;
    if (H5Fis_hdf5(path_.c_str()) <= 0) {
      throw TableError(path_ + " is not an HDF5 file", "a CSV file has another ending, as .csv");
    }
    try {
      file_ = hdf5::open_file(path_);
    } catch (const hdf5::Error& error) {
      throw TableError(fmt::format("cannot read {}: {}", path_, error.what()),
                       "expected a complete HDF5 file");
    }
    // A recording of ours is sealed.
    sealed_ = H5Lexists(file_, "salvo", H5P_DEFAULT) > 0;
    if (sealed_) verify(path_);
  }
  ~Hdf5Table() override = default;
  Hdf5Table(const Hdf5Table&) = delete;
  Hdf5Table& operator=(const Hdf5Table&) = delete;

  std::vector<double> column(const std::string& name, const std::string& unit) override {
    const hdf5::Session session;
    try {
      return read(name, unit);
    } catch (const hdf5::Error& error) {
      throw TableError(fmt::format("{}: cannot read dataset \"{}\": {}", path_, name, error.what()),
                       "expected an intact dataset");
    }
  }

 private:
  [[noreturn]] void refuse(const std::string& name, const std::string& problem,
                           const std::string& hint) const {
    throw TableError(fmt::format("{}: dataset \"{}\" {}", path_, name, problem), hint);
  }

  static void verify(const std::filesystem::path& path) {
    try {
      verify_seal(path);
    } catch (const CorruptFile& error) {
      throw TableError(error.what(), "run its scene again");
    }
  }

  std::vector<double> read(const std::string& name, const std::string& unit) {
    const hid_t id = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
    if (id < 0) throw scene::no_such_column(path_, "dataset", name, columns_in(file_));
    const Handle dataset(id, "open a dataset");
    const hdf5::Extents extents = hdf5::extents_of(dataset);
    if (extents.size() != 1) {
      refuse(name, fmt::format("has {} dimensions", extents.size()),
             "expected one: a number for each row");
    }
    if (!is_number(hdf5::type_of_dataset(dataset))) {
      refuse(name, "does not hold numbers", "expected integers or floating-point numbers");
    }
    if (extents[0] == 0) refuse(name, "has no rows", "expected a number for each row");
    if (first_.empty()) {
      first_ = name;
      rows_ = extents[0];
    } else if (extents[0] != rows_) {
      refuse(name, fmt::format("has {} rows, but \"{}\" has {}", extents[0], first_, rows_),
             "columns go together: expected one length");
    }
    require_sources(dataset, name);
    std::vector<double> values(rows_);
    hdf5::read_all(dataset, hdf5::type_of<double>(), values.data());
    for (std::size_t row = 0; row < rows_; ++row) {
      if (std::isfinite(values[row])) continue;
      refuse(name, fmt::format("is {} in row {}", values[row], row + 1),
             "expected a finite number in every row");
    }
    convert(values, name, units_of(dataset, name), unit);
    return values;
  }

  // HDF5 reads the fill value, often zero, where a file or its dataset is missing that a virtual
  // dataset shows.
  void require_sources(hid_t dataset, const std::string& name) {
    const Handle properties(H5Dget_create_plist(dataset), "read dataset properties");
    if (H5Pget_layout(properties) != H5D_VIRTUAL) return;
    std::size_t count = 0;
    checked(H5Pget_virtual_count(properties, &count), "list the parts of a dataset");
    for (std::size_t i = 0; i < count; ++i) {
      const std::string file = source_name(&H5Pget_virtual_filename, properties, i);
      const std::string path = source_name(&H5Pget_virtual_dsetname, properties, i);
      // A name with % stands for as many files or datasets as there are.
      if ((file + path).find('%') != std::string::npos) continue;
      if (file == ".") {  // the file itself
        require_dataset(file_, path, path_, name);
        continue;
      }
      const std::filesystem::path source = std::filesystem::path(path_).parent_path() / file;
      if (!std::filesystem::exists(source)) {
        refuse(name, fmt::format("shows rows of {}, which is missing", source.string()),
               "it must lie beside the file that shows it");
      }
      if (sealed_ && !verified_.contains(source.string())) {
        verify(source);
        verified_.insert(source.string());
      }
      require_dataset(hdf5::open_file(source), path, source.string(), name);
    }
  }

  // The file or the dataset that part `i` of a virtual dataset shows.
  template <class Get>
  static std::string source_name(Get get, hid_t properties, std::size_t i) {
    const auto length =
        static_cast<std::size_t>(checked<hssize_t>(get(properties, i, nullptr, 0), "name a part"));
    std::string text(length, '\0');
    checked<hssize_t>(get(properties, i, text.data(), length + 1), "name a part");
    return text;
  }

  void require_dataset(hid_t file, const std::string& path, const std::string& source,
                       const std::string& name) const {
    const hid_t id = H5Dopen2(file, path.c_str(), H5P_DEFAULT);
    if (id < 0) {
      refuse(name, fmt::format("shows rows of {}, which has no dataset \"{}\"", source, path),
             "expected the file that it was made with");
    }
    const Handle dataset(id, "open a dataset");
  }

  // The attribute, or "" without one.
  std::string units_of(hid_t dataset, const std::string& name) const {
    if (checked(H5Aexists(dataset, "units"), "look for an attribute") == 0) return {};
    try {
      std::string units = hdf5::read_text_attribute(dataset, "units");
      units.resize(std::min(units.find('\0'), units.size()));
      units.resize(units.find_last_not_of(' ') + 1);
      return units;
    } catch (const hdf5::Error&) {
      refuse(name, "has an attribute \"units\" that is not a text",
             "expected a text such as \"m/s\", or no such attribute");
    }
  }

  // As the cells of a CSV file are converted: a column gives the same inputs in either.
  void convert(std::vector<double>& values, const std::string& name, const std::string& units,
               const std::string& unit) const {
    if (units.empty()) return;
    try {
      if (scene::quantity("1 " + units, unit) == 1) return;
    } catch (const scene::UnitError& error) {
      refuse(name, fmt::format("has the units \"{}\": {}", units, error.what()), error.hint());
    }
    for (std::size_t row = 0; row < values.size(); ++row) {
      try {
        values[row] = scene::quantity(fmt::format("{} {}", values[row], units), unit);
      } catch (const scene::UnitError& error) {
        refuse(name, fmt::format("in row {}: {}", row + 1, error.what()), error.hint());
      }
    }
  }

  std::string path_;
  Handle file_;
  bool sealed_ = false;
  std::string first_;  // column that was asked for
  hsize_t rows_ = 0;
  std::set<std::string> verified_;  // intact files that datasets show
};

}  // namespace

std::unique_ptr<scene::InputTable> open_hdf5_table(const std::string& path) {
  return std::make_unique<Hdf5Table>(path);
}

}  // namespace salvo::recording
