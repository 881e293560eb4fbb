// The floating-point environment of the contract: round to nearest, no flush to zero, no traps. It
// belongs to a thread, and a foreign library built with -ffast-math sets flush-to-zero when it is
// loaded; so every task sets it and restores the caller's on the way out.
#pragma once

#include <cstdint>

namespace salvo::solver {

class FloatingPointEnvironment {
 public:
  FloatingPointEnvironment() : saved_(read()) { write(contract); }
  ~FloatingPointEnvironment() { write(saved_); }
  FloatingPointEnvironment(const FloatingPointEnvironment&) = delete;
  FloatingPointEnvironment& operator=(const FloatingPointEnvironment&) = delete;

  /// True when rounding and flushing of this thread are the contract's (sticky flags aside).
  static bool in_force() { return (read() & mode_bits) == (contract & mode_bits); }

 private:
#if defined(__x86_64__)
  using Word = std::uint32_t;
  static constexpr Word contract = 0x1F80;   // all exceptions masked, nearest, no FTZ, no DAZ
  static constexpr Word mode_bits = 0xFFC0;  // all but the sticky exception flags
  static Word read() { return __builtin_ia32_stmxcsr(); }
  static void write(Word word) { __builtin_ia32_ldmxcsr(word); }
#elif defined(__aarch64__)
  using Word = std::uint64_t;
  static constexpr Word contract = 0;
  static constexpr Word mode_bits = ~Word{0};
  static Word read() {
    Word word;
    __asm__ volatile("mrs %0, fpcr" : "=r"(word));
    return word;
  }
  static void write(Word word) { __asm__ volatile("msr fpcr, %0" : : "r"(word)); }
#else
#error "salvo runs on x86-64 and AArch64"
#endif

  Word saved_;
};

}  // namespace salvo::solver
