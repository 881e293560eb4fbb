#include "recording/frame_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <stdexcept>
#include <string_view>
#include <type_traits>

#include "recording/column_reader.hpp"
#include "recording/hdf5.hpp"
#include "recording/sealed_hdf5.hpp"
#include "scene/words.hpp"
#include "soa/particle_fields.hpp"
#include "solver/diagnostic_fields.hpp"

namespace salvo::recording {

namespace {

using hdf5::Handle;

FrameInfo info_of(hid_t file) {
  using hdf5::read_attribute;
  FrameInfo info;
  const Handle salvo = hdf5::open_group(file, "salvo");
  info.step = read_attribute<std::int64_t>(salvo, "step");
  info.time = read_attribute<double>(salvo, "time");
  info.seed = read_attribute<std::uint64_t>(salvo, "seed");
  const auto precision =
      scene::named<soa::Precision>(hdf5::read_text_attribute(salvo, "precision"));
  if (!precision) throw hdf5::Error("its precision is unknown");
  info.precision = *precision;
  info.fraction = read_attribute<double>(salvo, "fraction");
  info.complete = read_attribute<std::uint8_t>(salvo, "complete") != 0;
  info.scene_text = hdf5::read_text_attribute(salvo, "scene");
  info.overrides = hdf5::read_texts_attribute(salvo, "overrides");
  info.scene_digest = solver::digest_from(hdf5::read_text_attribute(salvo, "scene_digest"));
  info.version = hdf5::read_text_attribute(salvo, "version");
  info.contract = read_attribute<std::int32_t>(salvo, "contract");
  info.state_hash = solver::digest_from(hdf5::read_text_attribute(salvo, "state_hash"));
  info.tally.impacts = read_attribute<std::uint64_t>(salvo, "impacts");
  info.tally.rests = read_attribute<std::uint64_t>(salvo, "rests");
  info.removed = read_attribute<std::uint64_t>(salvo, "removed");

  const Handle digests = hdf5::open_group(salvo, "digests");
  for (const std::string& field : hdf5::attribute_names(digests)) {
    const std::string digits = hdf5::read_text_attribute(digests, field);
    info.field_digests.push_back({field, solver::digest_from(digits)});
  }
  const Handle uniform = hdf5::open_group(salvo, "uniform");
  for (const std::string& field : hdf5::attribute_names(uniform)) {
    info.uniform.push_back({field, read_attribute<double>(uniform, field)});
  }

  const Handle diagnostics = hdf5::open_group(salvo, "diagnostics");
  const std::vector<std::string> reported = hdf5::attribute_names(diagnostics);
  if (std::binary_search(reported.begin(), reported.end(),
                         std::string(solver::first_contact_field))) {
    info.diagnostics.contacts.emplace();
  }
  for_each_field(info.diagnostics, [&](std::string_view field, std::string_view, auto& member) {
    const std::string name(field);
    using Member = std::remove_reference_t<decltype(member)>;
    if constexpr (std::is_arithmetic_v<Member>) {
      member = read_attribute<Member>(diagnostics, name);
    } else {
      member = hdf5::read_array_attribute<double, 3>(diagnostics, name);
    }
  });
  return info;
}

// The place of a field in the list of fields; unknown ones come last.
std::size_t place_of(const FrameColumn& column) {
  const std::span<const soa::Field> fields = soa::particle_fields;
  return static_cast<std::size_t>(
      std::find_if(fields.begin(), fields.end(),
                   [&](const soa::Field& field) { return field.name == column.name; }) -
      fields.begin());
}

}  // namespace

FrameInfo read_frame_info(const std::filesystem::path& path) {
  return with_sealed_hdf5(path, "a frame", [](hid_t file) { return info_of(file); });
}

Frame read_frame(const std::filesystem::path& path) {
  return with_sealed_hdf5(path, "a frame", [](hid_t file) {
    Frame frame{info_of(file), 0, {}, 0, {}};
    const auto read_group = [&](const char* name, std::vector<FrameColumn>& columns,
                                std::size_t& count) {
      const Handle group = hdf5::open_group(file, name);
      for (const std::string& dataset : hdf5::names_in(group)) {
        std::size_t rows = 0;
        columns.push_back(read_column(group, dataset, frame.info.precision, rows));
        if (columns.size() > 1 && rows != count) {
          throw hdf5::Error(fmt::format("dataset {} has another number of rows", dataset));
        }
        count = rows;
      }
    };
    read_group("particles", frame.columns, frame.rows);
    const std::vector<std::string> groups = hdf5::names_in(file);
    if (std::find(groups.begin(), groups.end(), "contacts") != groups.end()) {
      read_group("contacts", frame.contact_columns, frame.contacts);
    }
    std::stable_sort(
        frame.columns.begin(), frame.columns.end(),
        [](const FrameColumn& a, const FrameColumn& b) { return place_of(a) < place_of(b); });
    return frame;
  });
}

}  // namespace salvo::recording
