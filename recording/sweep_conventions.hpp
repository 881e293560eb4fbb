// What the files of a sweep say to programs that know nothing of salvo, by the conventions of
// netCDF-4 and CF: which datasets have which dimensions, and where the numbers come from.
#pragma once

#include "recording/hdf5.hpp"
#include "scene/sweep_scene.hpp"

namespace salvo::recording {

/// To be called once, when all columns and samples of the file are there, as real or as virtual
/// datasets. Columns are over the dimension `id`, samples over `id` and `level`; adds the dataset
/// samples/level. Throws hdf5::Error.
void write_conventions(hid_t file, const scene::SweepScene& scene, const solver::Sweep& sweep);

/// The group "salvo" with what parts and the file of all rows both say: the scene, its digest, the
/// meaning of outcomes, and the versions. Throws hdf5::Error.
hdf5::Handle create_identity(hid_t file, const scene::SweepScene& scene,
                             const solver::Sweep& sweep);

/// The field of the dataset samples/time.
soa::Field sample_time_field();

}  // namespace salvo::recording
