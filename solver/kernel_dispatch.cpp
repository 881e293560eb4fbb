// Picks the kernels of an instruction set at run time.
#include <stdexcept>
#include <string>

#include "solver/contact_pass.hpp"
#include "solver/particle_pass.hpp"

namespace salvo::solver {

#define SALVO_DECLARE_TABLES(ISA)                     \
  namespace ISA {                                     \
  extern const ParticleKernels particle_kernel_table; \
  extern const ContactKernels contact_kernel_table;   \
  }
SALVO_DECLARE_TABLES(scalar)
#if defined(__x86_64__)
SALVO_DECLARE_TABLES(sse2)
SALVO_DECLARE_TABLES(avx2)
#ifndef SALVO_NO_AVX512
SALVO_DECLARE_TABLES(avx512)
#endif
#elif defined(__aarch64__)
SALVO_DECLARE_TABLES(neon)
#endif
#undef SALVO_DECLARE_TABLES

namespace {

struct Tables {
  const ParticleKernels& particle;
  const ContactKernels& contact;
};

#define SALVO_TABLES(ISA) \
  { ISA::particle_kernel_table, ISA::contact_kernel_table }
Tables tables_of(Isa isa) {
  switch (isa) {
    case Isa::scalar:
      return SALVO_TABLES(scalar);
#if defined(__x86_64__)
    case Isa::sse2:
      return SALVO_TABLES(sse2);
    case Isa::avx2:
      return SALVO_TABLES(avx2);
#ifndef SALVO_NO_AVX512
    case Isa::avx512:
      return SALVO_TABLES(avx512);
#endif
#elif defined(__aarch64__)
    case Isa::neon:
      return SALVO_TABLES(neon);
#endif
    default:
      break;
  }
  throw std::invalid_argument("this build has no kernels for " + std::string(name(isa)));
}
#undef SALVO_TABLES

}  // namespace

const ParticleKernels& particle_kernels(Isa isa) { return tables_of(isa).particle; }
const ContactKernels& contact_kernels(Isa isa) { return tables_of(isa).contact; }

}  // namespace salvo::solver
