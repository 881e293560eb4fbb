// The state hash: the digest of all state in id order.
//
// For each stored field, leaves of 4096 consecutive serials of a stream (live rows; id, then the
// value's components, little-endian, one canonical NaN), XXH3-128 each; then XXH3-128 over (stream,
// leaf, digest) in order; the total over the fields' names and digests. The id's own column has the
// id alone; numbers of streams and leaves are words of 64 bits, a digest is its high word and then
// its low one, a name ends in a zero byte. Leaves are independent, so they hash in parallel and
// would merge across shards.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "soa/table.hpp"
#include "solver/parallel.hpp"

namespace salvo::solver {

struct Digest {
  std::uint64_t high = 0;
  std::uint64_t low = 0;

  friend bool operator==(const Digest&, const Digest&) = default;
};

/// 32 hexadecimal digits.
std::string to_string(const Digest& digest);
/// The reverse. Throws std::invalid_argument.
Digest digest_from(std::string_view text);

struct FieldDigest {
  std::string_view field;
  Digest digest;
};

struct StateHash {
  Digest total;
  std::vector<FieldDigest> fields;
};

/// Adds the fields of another table to a hash.
void append(StateHash& hash, const StateHash& more);

/// The table must be sorted by id; rows of one id keep their order.
StateHash state_hash(const soa::Table& table, const Parallel& parallel);

/// XXH3-128 of bytes: recordings and checkpoints use it as their checksum.
Digest digest_of(const void* bytes, std::size_t size);

}  // namespace salvo::solver
