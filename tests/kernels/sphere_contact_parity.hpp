// The contact laws and the loads of records behind plain function pointers, for each instruction
// set. Arrays are 64-byte aligned and their length is a multiple of 64.
#pragma once

#include <cstddef>
#include <cstdint>

namespace salvo::tests::sphere_contact_parity {

inline constexpr std::size_t results = 44;

template <class T>
struct Run {
  std::size_t rows = 0;
  const T* normal[3] = {};  // unit
  const T* velocity[3] = {};
  const T* displacement[3] = {};
  const T* overlap = nullptr;
  const T* mass = nullptr;
  const T* radius = nullptr;
  const T* zeta = nullptr;
  const T* stiffness = nullptr;
  const T* friction = nullptr;
  T dt = 0;
  T* result[results] = {};  // two laws, each seen from both sides
};

template <class T>
struct Quads {
  std::size_t rows = 0;     // of 16 numbers
  const T* from = nullptr;  // records
  const std::int32_t* index = nullptr;
  T* loaded = nullptr;  // four columns of `rows`, from the second quad of the records
  T* stored = nullptr;  // records, their third quad
};

struct Table {
  void (*contact_single)(const Run<float>&);
  void (*contact_twice)(const Run<double>&);
  void (*quads_single)(const Quads<float>&);
  void (*quads_twice)(const Quads<double>&);
};

}  // namespace salvo::tests::sphere_contact_parity
