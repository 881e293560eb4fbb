// Picks the contact kernels of an instruction set at run time.
#include <stdexcept>
#include <string>

#include "solver/contact_pass.hpp"

namespace salvo::solver {

#define SALVO_DECLARE_TABLE(ISA)                    \
  namespace ISA {                                   \
  extern const ContactKernels contact_kernel_table; \
  }
SALVO_DECLARE_TABLE(scalar)
#if defined(__x86_64__)
SALVO_DECLARE_TABLE(sse2)
SALVO_DECLARE_TABLE(avx2)
#ifndef SALVO_NO_AVX512
SALVO_DECLARE_TABLE(avx512)
#endif
#elif defined(__aarch64__)
SALVO_DECLARE_TABLE(neon)
#endif
#undef SALVO_DECLARE_TABLE

const ContactKernels& contact_kernels(Isa isa) {
  switch (isa) {
    case Isa::scalar:
      return scalar::contact_kernel_table;
#if defined(__x86_64__)
    case Isa::sse2:
      return sse2::contact_kernel_table;
    case Isa::avx2:
      return avx2::contact_kernel_table;
#ifndef SALVO_NO_AVX512
    case Isa::avx512:
      return avx512::contact_kernel_table;
#endif
#elif defined(__aarch64__)
    case Isa::neon:
      return neon::contact_kernel_table;
#endif
    default:
      break;
  }
  throw std::invalid_argument("this build has no kernels for " + std::string(name(isa)));
}

}  // namespace salvo::solver
