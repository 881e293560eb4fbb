// clang-format off
// Composes the HDF5 file of a frame or checkpoint.
//
//   /particles/<field>   [N] or [N,3], contiguous; attributes units, meaning
//   /salvo               attributes: step, time, seed, precision, scene, overrides, scene_digest, version, ..
//   /salvo/diagnostics   attributes: count, mass, momentum, energies, bounds, ..
//   /salvo/digests       attributes: the state hash's digest of each stored field
//   /salvo/uniform       attributes: the value of each field that all particles share
//   /VTKHDF              what ParaView reads: an unstructured grid of one poly-vertex cell whose points and
//                        point data are soft links to /particles; only in a file that has positions
//
// A shared field that the scene wants recorded is a dataset like any other, but a constant one, which takes
// no space.
// clang-format on
#pragma once

#include <cstddef>
#include <vector>

#include "recording/frame.hpp"
#include "recording/hdf5.hpp"
#include "recording/selection.hpp"
#include "scene/scene.hpp"
#include "soa/field.hpp"

namespace salvo::recording {

class FrameWriter {
 public:
  /// The scene must outlive the writer.
  explicit FrameWriter(const scene::Scene& scene);

  /// `fraction` of the particles are in `rows`. With the contacts, where they remember anything, a
  /// file of all rows holds the full state. Throws hdf5::Error. Not for two threads at a time.
  hdf5::MemoryFile compose(const StateInfo& state, const Rows& rows, double fraction,
                           const soa::Table* contacts = nullptr);

 private:
  hdf5::Handle create_column(hid_t group, const FieldRows& columns, const Rows& rows) const;
  void write_contacts(hid_t file, const soa::Table& contacts) const;
  void write_salvo(hid_t file, const StateInfo& state, const Rows& rows, double fraction,
                   bool complete) const;
  void write_vtk(hid_t file, const Rows& rows);
  void write_connectivity(hid_t group, std::size_t points);

  const scene::Scene& scene_;
  std::string scene_digest_;
  // Deflated blocks of the numbers 0, 1, 2, ..: the same in every frame.
  std::vector<std::vector<std::byte>> deflated_;
  std::size_t deflated_from_ = 0;  // bytes that each was deflated from
};

}  // namespace salvo::recording
