# salvo_flags: what every translation unit of salvo, and of a program that includes its kernels, is compiled with.
#
# -ffp-contract=off: gcc fuses a*b+c by default, across statements and on intrinsics, and ignores the FP_CONTRACT pragma.
# One fused multiply-add is one different bit. Kernels are headers, so the flag is a requirement of the users too.
# -fno-math-errno: sqrt inlines; no bit depends on it.
add_library(salvo_flags INTERFACE)
target_compile_features(salvo_flags INTERFACE cxx_std_20)
target_compile_options(salvo_flags INTERFACE -ffp-contract=off -fno-math-errno -fno-fast-math)
# xsimd would fuse in the AVX architectures when the compiler allows it.
target_compile_definitions(salvo_flags INTERFACE XSIMD_WITH_FMA3_AVX=0 XSIMD_WITH_FMA3_AVX2=0)
if(NOT SALVO_ENABLE_AVX512)
  target_compile_definitions(salvo_flags INTERFACE SALVO_NO_AVX512)
endif()

# Ours alone: warnings, sanitizers.
add_library(salvo_own_flags INTERFACE)
target_compile_options(salvo_own_flags INTERFACE
  -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Wold-style-cast -Wpedantic
  # Passing 64-byte vectors by value changed ABI between gcc versions; they never cross a library border here.
  -Wno-psabi -Wno-ignored-attributes
  # gcc 12 finds its own avx512 intrinsics uninitialized, and overlaps in its own std::string (PR 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
if(SALVO_WARNINGS_AS_ERRORS)
  target_compile_options(salvo_own_flags INTERFACE -Werror)
endif()
if(SALVO_SANITIZE)
  add_compile_options(-fsanitize=${SALVO_SANITIZE} -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${SALVO_SANITIZE})
endif()
