#include "recording/sweep_part.hpp"

#include <algorithm>
#include <cstring>

#include "recording/column_reader.hpp"
#include "recording/field_dataset.hpp"
#include "recording/sealed_hdf5.hpp"
#include "recording/sweep_conventions.hpp"
#include "scene/words.hpp"

namespace salvo::recording {

namespace {

using hdf5::Handle;
using hdf5::write_attribute;

// The group and name of a field's dataset.
struct Place {
  std::string group;
  std::string name;
};
Place place_of(std::string_view field) {
  const std::size_t dot = field.find('.');
  if (dot == std::string_view::npos) return {"", std::string(field)};
  return {std::string(field.substr(0, dot)), std::string(field.substr(dot + 1))};
}

PartInfo info_of(hid_t file) {
  PartInfo info;
  const Handle salvo = hdf5::open_group(file, "salvo");
  info.first = hdf5::read_attribute<std::uint64_t>(salvo, "first");
  info.rows = hdf5::read_attribute<std::uint64_t>(salvo, "rows");
  info.row_digest = solver::digest_from(hdf5::read_text_attribute(salvo, "row_digest"));
  info.hash = solver::digest_from(hdf5::read_text_attribute(salvo, "hash"));
  const auto precision =
      scene::named<soa::Precision>(hdf5::read_text_attribute(salvo, "precision"));
  if (!precision) throw hdf5::Error("its precision is unknown");
  info.precision = *precision;
  info.columns = hdf5::read_texts_attribute(salvo, "columns");
  info.outcomes = hdf5::read_texts_attribute(salvo, "outcomes");
  info.scene_path = hdf5::read_text_attribute(salvo, "scene_path");
  info.scene_text = hdf5::read_text_attribute(salvo, "scene");
  info.overrides = hdf5::read_texts_attribute(salvo, "overrides");
  return info;
}

}  // namespace

std::string dataset_path(std::string_view field) {
  const Place place = place_of(field);
  return place.group.empty() ? "/" + place.name : "/" + place.group + "/" + place.name;
}

void write_part(const std::filesystem::path& path, const scene::SweepScene& scene,
                const solver::Sweep& sweep, const solver::SweepRows& rows,
                const solver::Digest& hash) {
  const hdf5::Session session;
  hdf5::MemoryFile file;
  const soa::Table& table = rows.table;
  std::string open_name;
  Handle open;
  const auto group_of = [&](const Place& place) -> hid_t {
    if (place.group.empty()) return file;
    if (place.group != open_name) {
      open = hdf5::create_group(file, place.group);
      open_name = place.group;
    }
    return open;
  };
  // Fields of one group are neighbours.
  std::vector<std::string> names;
  for (std::size_t f = 0; f < table.fields().size(); ++f) {
    const soa::Field& field = table.fields()[f];
    const Place place = place_of(field.name);
    names.emplace_back(field.name);
    const bool stored = table.stored(f);
    const Handle dataset =
        create_field_dataset(group_of(place), place.name, field, table.precision(), {table.rows()},
                             stored ? std::nullopt : std::optional(table.uniform(f)));
    if (stored) {
      hdf5::write_all(dataset, type_of(field.scalar, table.precision()), table.bytes(f, 0));
    }
  }
  if (sweep.levels() != 0) {
    const Handle samples = hdf5::create_group(file, "samples");
    const auto write = [&](const soa::Field& field, const std::vector<double>& values) {
      const Handle dataset =
          create_field_dataset(samples, std::string(field.name), field, soa::Precision::float64,
                               {table.rows(), sweep.levels()}, std::nullopt);
      hdf5::write_all(dataset, hdf5::type_of<double>(), values.data());
    };
    write(sample_time_field(), rows.sample_time);
    for (std::size_t f = 0; f < rows.samples.size(); ++f) {
      write(sweep.sample_fields()[f], rows.samples[f]);
    }
  }
  write_conventions(file, scene, sweep);
  {
    const Handle salvo = create_identity(file, scene, sweep);
    write_attribute(salvo, "first", std::uint64_t{table.rows() == 0 ? 0 : table.ids()[0]});
    write_attribute(salvo, "rows", std::uint64_t{table.rows()});
    write_attribute(salvo, "hash", std::string_view(to_string(hash)));
    write_attribute(salvo, "precision", scene::name(table.precision()));
    write_attribute(salvo, "columns", names);
  }
  write_sealed(path, file.bytes(), Durability::process);
}

PartInfo read_part_info(const std::filesystem::path& path) {
  return with_sealed_hdf5(path, "a part of a sweep", [](hid_t file) { return info_of(file); });
}

PartColumns read_part_columns(const std::filesystem::path& path,
                              const std::vector<std::string>& names) {
  // The seal was verified when the part was written or taken over.
  const hdf5::Session session;
  try {
    const Handle file = hdf5::open_file(path);
    PartColumns columns;
    for (const std::string& name : names) {
      const Handle dataset = hdf5::open_dataset(file, dataset_path(name));
      std::vector<double>& values = columns.values.emplace_back(hdf5::extents_of(dataset).at(0));
      hdf5::read_all(dataset, hdf5::type_of<double>(), values.data());
    }
    const Handle dataset = hdf5::open_dataset(file, "/outcome");
    columns.outcome.resize(hdf5::extents_of(dataset).at(0));
    hdf5::read_all(dataset, hdf5::type_of<std::uint32_t>(), columns.outcome.data());
    return columns;
  } catch (const hdf5::Error& error) {
    throw CorruptFile(fmt::format("cannot read {}: {}", path.string(), error.what()));
  }
}

PartRows read_part(const std::filesystem::path& path) {
  return with_sealed_hdf5(path, "a part of a sweep", [](hid_t file) {
    PartRows part{info_of(file), {}};
    const PartInfo& info = part.info;
    Frame& frame = part.frame;
    frame.info.precision = info.precision;
    frame.rows = info.rows;
    for (const std::string& name : info.columns) {
      std::size_t rows = 0;
      FrameColumn column = read_column(file, dataset_path(name), info.precision, rows);
      column.name = name;
      if (name == "outcome") column.words = info.outcomes;
      frame.columns.push_back(std::move(column));
    }
    return part;
  });
}

}  // namespace salvo::recording
