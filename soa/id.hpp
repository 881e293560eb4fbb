// Particle ids: 64 bits, the emitter's stream (24) and the serial within it (40). Random draws and
// the state hash are keyed by them, so adding, removing or running an emitter alone changes no
// other particle.
#pragma once

#include <cstdint>

namespace salvo::soa {

using Id = std::uint64_t;

inline constexpr int serial_bits = 40;
inline constexpr std::uint64_t max_serial = (std::uint64_t{1} << serial_bits) - 1;
inline constexpr std::uint64_t max_stream = (std::uint64_t{1} << 24) - 1;

constexpr Id make_id(std::uint64_t stream, std::uint64_t serial) {
  return (stream << serial_bits) | serial;
}
constexpr std::uint64_t stream_of(Id id) { return id >> serial_bits; }
constexpr std::uint64_t serial_of(Id id) { return id & max_serial; }

}  // namespace salvo::soa
