// Instruction sets: one tag type each, and the namespace that keeps their code apart.
//
// Everything under kernels/, integrators/ and models/ sits in `inline namespace SALVO_ISA`. A
// translation unit is compiled for one instruction set (cmake/SalvoKernels.cmake defines
// SALVO_ISA), so an inline function that it emits carries the instruction set in its name and the
// linker can never keep an AVX-512 copy for a caller on an older machine. Ordinary translation
// units compute on scalar lanes in namespace `baseline`.
#pragma once

#ifdef __FAST_MATH__
#error \
    "salvo cannot keep its bits under -ffast-math: remove it from the flags of this translation unit"
#endif

// Marks a function whose packs are to live in registers: all that it calls becomes part of it. Not
// under sanitizers, whose checks would make it too long to compile, nor where a build that is not
// for speed asks (SALVO_NO_FLATTEN).
#if defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && \
    !defined(SALVO_NO_FLATTEN)
#define SALVO_FLATTEN [[gnu::flatten]]
#else
#define SALVO_FLATTEN
#endif

#ifndef SALVO_ISA
#define SALVO_ISA baseline
#define SALVO_ISA_scalar 1
#endif

namespace salvo::kernels {

/// One value a lane: the executable specification that every other instruction set must match bit
/// for bit.
struct Scalar {};
/// x86-64 baseline: 4 floats or 2 doubles.
struct Sse2 {};
/// 8 floats or 4 doubles; fused multiply-add is never used.
struct Avx2 {};
/// AVX-512 F, CD, DQ, BW, VL: 16 floats or 8 doubles.
struct Avx512 {};
/// AArch64 Advanced SIMD: 4 floats or 2 doubles.
struct Neon {};

inline namespace SALVO_ISA {

#if defined(SALVO_ISA_avx512)
using NativeIsa = Avx512;
#elif defined(SALVO_ISA_avx2)
using NativeIsa = Avx2;
#elif defined(SALVO_ISA_sse2)
using NativeIsa = Sse2;
#elif defined(SALVO_ISA_neon)
using NativeIsa = Neon;
#else
using NativeIsa = Scalar;
#endif

}  // namespace SALVO_ISA
}  // namespace salvo::kernels
