// Reaches what a test source compiled by salvo_add_kernels() exposes: one plain struct for each
// instruction set, picked at run time like the library's own kernels.
#pragma once

#include <stdexcept>

#include "solver/isa.hpp"

#if defined(__aarch64__)
#define SALVO_TEST_ISAS(DO) DO(scalar) DO(neon)
#elif defined(SALVO_NO_AVX512)
#define SALVO_TEST_ISAS(DO) DO(scalar) DO(sse2) DO(avx2)
#else
#define SALVO_TEST_ISAS(DO) DO(scalar) DO(sse2) DO(avx2) DO(avx512)
#endif

#define SALVO_TEST_DECLARE(ISA)  \
  namespace ISA {                \
  extern const Table test_table; \
  }
#define SALVO_TEST_CASE(ISA) \
  case solver::Isa::ISA:     \
    return ISA::test_table;

/// In the namespace of a type Table, in an ordinary source: defines const Table&
/// table_of(solver::Isa).
#define SALVO_TEST_TABLES                                 \
  SALVO_TEST_ISAS(SALVO_TEST_DECLARE)                     \
  inline const Table& table_of(solver::Isa isa) {         \
    switch (isa) {                                        \
      SALVO_TEST_ISAS(SALVO_TEST_CASE)                    \
      default:                                            \
        throw std::invalid_argument("not in this build"); \
    }                                                     \
  }
