// A frame in memory: what its attributes say and the columns it holds. A checkpoint is a frame that
// holds everything.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "soa/field.hpp"
#include "solver/particle_pass.hpp"
#include "solver/reduction.hpp"
#include "solver/state_hash.hpp"

namespace salvo::recording {

/// The state that a frame was taken from.
struct StateInfo {
  std::int64_t step = 0;
  double time = 0;  // s
  solver::StateHash hash;
  solver::Diagnostics diagnostics;
  solver::ContactTally tally;
  std::uint64_t removed = 0;  ///< particles removed because they went bad, since the start
};

struct NamedDigest {
  std::string field;
  solver::Digest digest;
};

struct UniformValue {
  std::string field;
  double value = 0;
};

/// What the attributes of a frame or checkpoint file say.
struct FrameInfo {
  std::int64_t step = 0;
  double time = 0;  // s
  std::uint64_t seed = 0;
  soa::Precision precision = soa::Precision::float32;
  double fraction = 1;    ///< of the particles that are kept
  bool complete = false;  ///< holds the full state: a run can go on from it
  std::string scene_text;
  std::vector<std::string> overrides;
  solver::Digest scene_digest;
  std::string version;
  int contract = 0;
  solver::Digest state_hash;               ///< of all particles, kept or not
  std::vector<NamedDigest> field_digests;  ///< likewise
  std::vector<UniformValue> uniform;       ///< fields with one value for all particles
  solver::Diagnostics diagnostics;
  solver::ContactTally tally;
  std::uint64_t removed = 0;
};

/// One dataset: rows x components, a row's components side by side.
struct FrameColumn {
  std::string name;
  std::string unit;
  std::string meaning;
  soa::Scalar scalar = soa::Scalar::real;
  std::size_t components = 1;
  std::vector<std::byte> values;
  std::vector<std::string> words;  ///< what the values stand for, where they stand for names
};

struct Frame {
  FrameInfo info;
  std::size_t rows = 0;
  std::vector<FrameColumn> columns;
  std::size_t contacts = 0;  ///< that remember something; in full states
  std::vector<FrameColumn> contact_columns;
};

}  // namespace salvo::recording
