#include "recording/frame_writer.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "recording/field_dataset.hpp"
#include "scene/words.hpp"
#include "soa/particle_fields.hpp"
#include "solver/diagnostic_fields.hpp"

namespace salvo::recording {

namespace {

using hdf5::Handle;
using soa::ParticleField;
using soa::Precision;

constexpr std::span<const soa::Field> fields = soa::particle_fields;
constexpr auto position = static_cast<std::size_t>(ParticleField::position);

hdf5::Extents extents_of(const soa::Field& field, std::size_t rows) {
  return field.components == 1 ? hdf5::Extents{rows} : hdf5::Extents{rows, field.components};
}

// Puts the components of each row side by side.
template <class Element>
void interleave(const std::array<const std::byte*, 3>& columns, std::size_t rows, std::byte* to) {
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t c = 0; c < 3; ++c) {
      std::memcpy(to, columns[c] + row * sizeof(Element), sizeof(Element));
      to += sizeof(Element);
    }
  }
}

void fill(const soa::Field& field, const FieldRows& columns, std::size_t rows, Precision precision,
          std::byte* to) {
  const std::size_t size = size_of(field.scalar, precision);
  if (field.components == 1) {
    std::memcpy(to, columns.components[0], rows * size);
  } else if (size == 4) {
    interleave<float>(columns.components, rows, to);
  } else {
    interleave<double>(columns.components, rows, to);
  }
}

// One NaN, whatever the processor's arithmetic makes.
std::uint64_t canonical(std::uint64_t value) { return value; }
double canonical(double value) {
  return std::isnan(value) ? std::numeric_limits<double>::quiet_NaN() : value;
}
std::array<double, 3> canonical(const std::array<double, 3>& values) {
  return {canonical(values[0]), canonical(values[1]), canonical(values[2])};
}

}  // namespace

FrameWriter::FrameWriter(const scene::Scene& scene)
    : scene_(scene), scene_digest_(to_string(scene_digest(scene))) {}

hdf5::MemoryFile FrameWriter::compose(const StateInfo& state, const Rows& rows, double fraction,
                                      const soa::Table* contacts) {
  const hdf5::Session session;
  hdf5::MemoryFile file;
  // HDF5 makes room for the columns; they are filled in when it is done, which saves copies.
  std::vector<std::optional<std::size_t>> offsets;
  {
    const Handle particles = hdf5::create_group(file, "particles");
    for (const FieldRows& columns : rows.fields) {
      offsets.push_back(hdf5::offset_of(create_column(particles, columns, rows)));
    }
  }
  const bool remembers = solver::remembers_contacts(scene_.setup);
  write_salvo(file, state, rows, fraction, rows.complete && (contacts || !remembers));
  if (contacts && remembers) write_contacts(file, *contacts);
  write_vtk(file, rows);
  std::byte* bytes = file.bytes().data();
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    if (!offsets[i]) continue;
    fill(fields[rows.fields[i].field], rows.fields[i], rows.count, scene_.setup.precision,
         bytes + *offsets[i]);
  }
  return file;
}

Handle FrameWriter::create_column(hid_t group, const FieldRows& columns, const Rows& rows) const {
  const soa::Field& field = fields[columns.field];
  const bool stored = rows.stored[columns.field];
  return create_field_dataset(group, std::string(field.name), field, scene_.setup.precision,
                              extents_of(field, rows.count),
                              stored ? std::nullopt : std::optional(rows.uniform[columns.field]));
}

// What the contacts remember: /contacts, by particle and partner.
void FrameWriter::write_contacts(hid_t file, const soa::Table& contacts) const {
  const Handle group = hdf5::create_group(file, "contacts");
  const Rows rows = all_rows(contacts);
  std::vector<std::byte> values;
  for (const FieldRows& columns : rows.fields) {
    const soa::Field& field = contacts.fields()[columns.field];
    const Handle dataset =
        create_field_dataset(group, std::string(field.name), field, contacts.precision(),
                             extents_of(field, rows.count), std::nullopt);
    if (rows.count == 0) continue;
    values.resize(rows.count * field.components * size_of(field.scalar, contacts.precision()));
    fill(field, columns, rows.count, contacts.precision(), values.data());
    hdf5::write_all(dataset, type_of(field.scalar, contacts.precision()), values.data());
  }
}

void FrameWriter::write_salvo(hid_t file, const StateInfo& state, const Rows& rows, double fraction,
                              bool complete) const {
  using hdf5::write_attribute;
  const Handle salvo = hdf5::create_group(file, "salvo");
  write_attribute(salvo, "step", state.step);
  write_attribute(salvo, "time", state.time);
  write_attribute(salvo, "seed", scene_.setup.seed);
  write_attribute(salvo, "precision", scene::name(scene_.setup.precision));
  write_attribute(salvo, "fraction", fraction);
  write_attribute(salvo, "complete", static_cast<std::uint8_t>(complete));
  write_attribute(salvo, "scene", std::string_view(scene_.text));
  write_attribute(salvo, "overrides", scene_.overrides);
  write_attribute(salvo, "scene_digest", std::string_view(scene_digest_));
  write_attribute(salvo, "version", std::string_view(SALVO_VERSION));
  write_attribute(salvo, "contract", std::int32_t{scene::contract_version});
  write_attribute(salvo, "state_hash", std::string_view(to_string(state.hash.total)));
  write_attribute(salvo, "impacts", state.tally.impacts);
  write_attribute(salvo, "rests", state.tally.rests);
  write_attribute(salvo, "removed", state.removed);

  const Handle digests = hdf5::create_group(salvo, "digests");
  for (const solver::FieldDigest& digest : state.hash.fields) {
    write_attribute(digests, std::string(digest.field), std::string_view(to_string(digest.digest)));
  }
  const Handle uniform = hdf5::create_group(salvo, "uniform");
  for (std::size_t f = 0; f < rows.stored.size(); ++f) {
    if (rows.stored[f] || (soa::only_of_contacts(f) && !scene_.setup.contact_law)) continue;
    write_attribute(uniform, std::string(fields[f].name), rows.uniform[f]);
  }

  const Handle diagnostics = hdf5::create_group(salvo, "diagnostics");
  for_each_field(state.diagnostics,
                 [&](std::string_view field, std::string_view, const auto& member) {
                   write_attribute(diagnostics, std::string(field), canonical(member));
                 });
}

// ParaView 5.11 reads version 1.0 of this layout and nothing newer.
void FrameWriter::write_vtk(hid_t file, const Rows& rows) {
  const bool has_position = std::any_of(rows.fields.begin(), rows.fields.end(),
                                        [](const FieldRows& f) { return f.field == position; });
  if (!has_position) return;
  const Handle vtk = hdf5::create_group(file, "VTKHDF");
  hdf5::write_attribute(vtk, "Version", std::array<std::int64_t, 2>{1, 0});
  hdf5::write_attribute(vtk, "Type", std::string_view("UnstructuredGrid"));
  const auto write = [&](const char* name, auto value) {
    hdf5::write_dataset(vtk, name, std::span<const decltype(value)>(&value, 1));
  };
  constexpr std::uint8_t poly_vertex = 2;
  write("NumberOfPoints", static_cast<std::int64_t>(rows.count));
  write("NumberOfCells", std::int64_t{1});
  write("NumberOfConnectivityIds", static_cast<std::int64_t>(rows.count));
  write("Types", poly_vertex);
  write_connectivity(vtk, rows.count);
  hdf5::create_soft_link(vtk, "Points", "/particles/position");
  const Handle data = hdf5::create_group(vtk, "PointData");
  for (const FieldRows& f : rows.fields) {
    if (f.field == position) continue;
    const std::string name(fields[f.field].name);
    hdf5::create_soft_link(data, name, "/particles/" + name);
  }
}

namespace {

// The numbers from `first` as HDF5's shuffle and deflate filters store them: all lowest bytes, then
// all second ones, ..
template <class Number>
std::vector<std::byte> deflated_numbers(std::size_t first, std::size_t count) {
  std::vector<std::byte> shuffled(count * sizeof(Number));
  for (std::size_t i = 0; i < count; ++i) {
    const auto number = static_cast<Number>(first + i);
    for (std::size_t b = 0; b < sizeof(Number); ++b) {
      shuffled[b * count + i] = static_cast<std::byte>(number >> (8 * b) & 0xff);
    }
  }
  uLongf size = compressBound(shuffled.size());
  std::vector<std::byte> deflated(size);
  compress2(reinterpret_cast<Bytef*>(deflated.data()), &size,
            reinterpret_cast<const Bytef*>(shuffled.data()), shuffled.size(), Z_BEST_SPEED);
  deflated.resize(size);
  return deflated;
}

}  // namespace

// Offsets and connectivity of the one cell: points 0, 1, 2, .. Both have the same type, or ParaView
// loses the cell: 32 bits unless there are too many points. The connectivity is the only compressed
// dataset, because it says so little; a block of it is deflated once and used for all frames.
void FrameWriter::write_connectivity(hid_t group, std::size_t points) {
  constexpr std::size_t block = 65536;
  const bool narrow = points <= std::numeric_limits<std::int32_t>::max();
  const hid_t type = narrow ? hdf5::type_of<std::int32_t>() : hdf5::type_of<std::int64_t>();
  const std::array<std::int64_t, 2> offsets{0, static_cast<std::int64_t>(points)};
  {
    const Handle dataset = hdf5::create_dataset(group, "Offsets", type, {offsets.size()});
    hdf5::write_all(dataset, hdf5::type_of<std::int64_t>(), offsets.data());
  }
  if (points == 0) {
    hdf5::create_dataset(group, "Connectivity", type, {0});
    return;
  }
  const std::size_t size = std::min(points, block);
  const std::size_t bytes = size * H5Tget_size(type);
  if (std::exchange(deflated_from_, bytes) != bytes) deflated_.clear();
  const Handle dataset = hdf5::create_deflated_dataset(group, "Connectivity", type, points, size);
  for (std::size_t first = 0, i = 0; first < points; first += size, ++i) {
    if (i == deflated_.size()) {
      deflated_.push_back(narrow ? deflated_numbers<std::int32_t>(first, size)
                                 : deflated_numbers<std::int64_t>(first, size));
    }
    hdf5::write_deflated_block(dataset, first, deflated_[i]);
  }
}

}  // namespace salvo::recording
