#include "recording/sweep_conventions.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "recording/dimension_scales.hpp"
#include "recording/field_dataset.hpp"
#include "recording/sweep_part.hpp"

namespace salvo::recording {

namespace {

constexpr const char* id_path = "/id";
constexpr const char* level_path = "/samples/level";

// The levels that the samples were taken at: values of the time or of a state.
void write_levels(hid_t file, const scene::SweepScene& scene, const solver::Sweep& sweep) {
  const solver::Samples& samples = scene.setup.integration.samples;
  const bool of_time = samples.quantity == solver::Samples::time;
  const soa::Field& state = sweep.sample_fields()[of_time ? 0 : samples.quantity];
  const std::string_view name = of_time ? "the time" : state.name;
  const hdf5::Handle group = hdf5::open_group(file, "samples");
  hdf5::write_dataset<double>(group, "level", samples.levels);
  const hdf5::Handle dataset = hdf5::open_dataset(group, "level");
  hdf5::write_attribute(dataset, "units", of_time ? "s" : state.unit);
  hdf5::write_attribute(dataset, "meaning",
                        std::string_view(fmt::format("of {}, at which samples are taken", name)));
}

}  // namespace

void write_conventions(hid_t file, const scene::SweepScene& scene, const solver::Sweep& sweep) {
  std::vector<Dimensions> datasets;
  for (const soa::Field& field : sweep.fields()) {
    const std::string path = dataset_path(field.name);
    if (path != id_path) datasets.push_back({path, {id_path}});
  }
  if (sweep.levels() != 0) {
    write_levels(file, scene, sweep);
    datasets.push_back({"/samples/time", {id_path, level_path}});
    for (const soa::Field& field : sweep.sample_fields()) {
      datasets.push_back({"/samples/" + std::string(field.name), {id_path, level_path}});
    }
  }
  write_dimension_scales(file, datasets);

  // No featureType. CF's "trajectory" is a path through longitude, latitude and a time of the
  // calendar, and its "point" a place there; rows have neither. A row is also no path, but its
  // inputs and its end, and samples may be at levels of any state.
  hdf5::write_attribute(file, "Conventions", std::string_view("CF-1.10"));
  if (!scene.title.empty()) {
    hdf5::write_attribute(file, "title", std::string_view(scene.title));
  }
  hdf5::write_attribute(
      file, "source",
      std::string_view(fmt::format("salvo {}, model {}", SALVO_VERSION, scene.model->name)));
}

hdf5::Handle create_identity(hid_t file, const scene::SweepScene& scene,
                             const solver::Sweep& sweep) {
  using hdf5::write_attribute;
  hdf5::Handle salvo = hdf5::create_group(file, "salvo");
  write_attribute(salvo, "row_digest", std::string_view(to_string(scene::row_digest(scene))));
  write_attribute(salvo, "outcomes", sweep.outcomes());
  write_attribute(salvo, "scene_path", std::string_view(scene.path));
  write_attribute(salvo, "scene", std::string_view(scene.text));
  write_attribute(salvo, "overrides", scene.overrides);
  write_attribute(salvo, "version", std::string_view(SALVO_VERSION));
  write_attribute(salvo, "contract", std::int32_t{scene::contract_version});
  return salvo;
}

soa::Field sample_time_field() {
  return {"time", soa::Scalar::real, 1, "s", "of the sample", 0, 0, 0};
}

}  // namespace salvo::recording
