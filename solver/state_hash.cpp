#include "solver/state_hash.hpp"

#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace salvo::solver {

namespace {

static_assert(std::endian::native == std::endian::little, "hashed bytes are little-endian");

constexpr std::uint64_t leaf_serials = 4096;

struct Leaf {
  std::uint64_t stream;
  std::uint64_t number;
  std::size_t first;
  std::size_t last;
};

std::vector<Leaf> leaves_of(const soa::Table& table) {
  std::vector<Leaf> leaves;
  const soa::Id* ids = table.ids();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::uint64_t stream = soa::stream_of(ids[row]);
    const std::uint64_t number = soa::serial_of(ids[row]) / leaf_serials;
    if (leaves.empty() || leaves.back().stream != stream || leaves.back().number != number) {
      leaves.push_back({stream, number, row, row});
    }
    leaves.back().last = row + 1;
  }
  return leaves;
}

template <class T>
T canonical(T value) {
  return value == value ? value : std::numeric_limits<T>::quiet_NaN();
}

// Appends one row's component; a NaN becomes the canonical one.
template <class Raw, bool Real>
std::byte* append(std::byte* to, const std::byte* column, std::size_t row) {
  Raw value;
  std::memcpy(&value, column + row * sizeof(Raw), sizeof(Raw));
  if constexpr (Real) value = canonical(value);
  std::memcpy(to, &value, sizeof(Raw));
  return to + sizeof(Raw);
}

template <class Raw, bool Real>
Digest leaf_digest(const soa::Table& table, std::size_t field, const Leaf& leaf) {
  const std::size_t components = table.fields()[field].components;
  const bool is_id = field == 0;
  thread_local std::vector<std::byte> room;
  room.resize((leaf.last - leaf.first) * (sizeof(soa::Id) + 3 * sizeof(double)));
  std::byte* const buffer = room.data();
  const std::byte* columns[3] = {};
  for (std::size_t c = 0; c < components; ++c) columns[c] = table.bytes(field, c);
  std::byte* end = buffer;
  for (std::size_t row = leaf.first; row < leaf.last; ++row) {
    std::memcpy(end, table.ids() + row, sizeof(soa::Id));
    end += sizeof(soa::Id);
    if (is_id) continue;
    for (std::size_t c = 0; c < components; ++c) end = append<Raw, Real>(end, columns[c], row);
  }
  return digest_of(buffer, static_cast<std::size_t>(end - buffer));
}

Digest leaf_digest(const soa::Table& table, std::size_t field, const Leaf& leaf) {
  switch (table.fields()[field].scalar) {
    case soa::Scalar::real:
      return table.precision() == soa::Precision::float32
                 ? leaf_digest<float, true>(table, field, leaf)
                 : leaf_digest<double, true>(table, field, leaf);
    case soa::Scalar::int32:
    case soa::Scalar::uint32:
      return leaf_digest<std::uint32_t, false>(table, field, leaf);
    case soa::Scalar::uint64:
      return leaf_digest<std::uint64_t, false>(table, field, leaf);
  }
  return {};
}

class Accumulator {
 public:
  void add(std::uint64_t word) {
    const auto* bytes = reinterpret_cast<const std::byte*>(&word);
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof word);
  }
  void add(std::string_view text) {
    const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
    bytes_.insert(bytes_.end(), bytes, bytes + text.size());
    bytes_.push_back(std::byte{0});
  }
  void add(const Digest& digest) {
    add(digest.high);
    add(digest.low);
  }
  Digest finish() const { return digest_of(bytes_.data(), bytes_.size()); }

 private:
  std::vector<std::byte> bytes_;
};

Digest total_of(const std::vector<FieldDigest>& fields) {
  Accumulator total;
  for (const FieldDigest& field : fields) {
    total.add(field.field);
    total.add(field.digest);
  }
  return total.finish();
}

}  // namespace

Digest digest_of(const void* bytes, std::size_t size) {
  const XXH128_hash_t hash = XXH3_128bits(bytes, size);
  return {hash.high64, hash.low64};
}

std::string to_string(const Digest& digest) {
  static constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint64_t word : {digest.high, digest.low}) {
    for (int shift = 60; shift >= 0; shift -= 4) text += digits[(word >> shift) & 15];
  }
  return text;
}

Digest digest_from(std::string_view text) {
  std::uint64_t words[2] = {0, 0};
  if (text.size() != 32) throw std::invalid_argument("a hash has 32 hexadecimal digits");
  for (std::size_t i = 0; i < 32; ++i) {
    const char c = text[i];
    int digit;
    if (c >= '0' && c <= '9') {
      digit = c - '0';
    } else if (c >= 'a' && c <= 'f') {
      digit = c - 'a' + 10;
    } else {
      throw std::invalid_argument("a hash has 32 hexadecimal digits");
    }
    words[i / 16] = words[i / 16] << 4 | static_cast<std::uint64_t>(digit);
  }
  return {words[0], words[1]};
}

StateHash state_hash(const soa::Table& table, const Parallel& parallel) {
  const std::vector<Leaf> leaves = leaves_of(table);
  std::vector<std::size_t> stored;
  for (std::size_t f = 0; f < table.fields().size(); ++f) {
    if (table.stored(f)) stored.push_back(f);
  }
  std::vector<Digest> digests(leaves.size() * stored.size());
  parallel.for_each(leaves.size(), [&](std::size_t leaf) {
    for (std::size_t f = 0; f < stored.size(); ++f) {
      digests[f * leaves.size() + leaf] = leaf_digest(table, stored[f], leaves[leaf]);
    }
  });
  StateHash hash;
  for (std::size_t f = 0; f < stored.size(); ++f) {
    Accumulator column;
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
      column.add(leaves[leaf].stream);
      column.add(leaves[leaf].number);
      column.add(digests[f * leaves.size() + leaf]);
    }
    const std::string_view field = table.fields()[stored[f]].name;
    hash.fields.push_back({field, column.finish()});
  }
  hash.total = total_of(hash.fields);
  return hash;
}

void append(StateHash& hash, const StateHash& more) {
  hash.fields.insert(hash.fields.end(), more.fields.begin(), more.fields.end());
  hash.total = total_of(hash.fields);
}

}  // namespace salvo::solver
