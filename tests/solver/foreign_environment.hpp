// The floating-point state that a foreign library or caller may have left behind: upward rounding,
// denormals flushed and read as zero.
#pragma once

#if defined(__x86_64__)
#define SALVO_TEST_FOREIGN_ENVIRONMENT

#include <cfenv>

namespace salvo::tests {

class ForeignEnvironment {
 public:
  ForeignEnvironment() : saved_(__builtin_ia32_stmxcsr()) {
    std::fegetenv(&environment_);
    std::fesetround(FE_UPWARD);
    __builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | flush_and_denormals_are_zero);
    mode_ = __builtin_ia32_stmxcsr() & modes;
  }
  ~ForeignEnvironment() {
    std::fesetenv(&environment_);
    __builtin_ia32_ldmxcsr(saved_);
  }
  ForeignEnvironment(const ForeignEnvironment&) = delete;
  ForeignEnvironment& operator=(const ForeignEnvironment&) = delete;

  /// Nobody has changed it and forgotten to change it back.
  bool untouched() const {
    return (__builtin_ia32_stmxcsr() & modes) == mode_ && std::fegetround() == FE_UPWARD;
  }

 private:
  static constexpr unsigned flush_and_denormals_are_zero = 0x8040;
  static constexpr unsigned modes = 0xFFC0;
  unsigned saved_;
  unsigned mode_;
  std::fenv_t environment_;
};

}  // namespace salvo::tests
#endif
