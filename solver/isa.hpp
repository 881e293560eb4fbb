// Instruction sets at run time: which ones this binary holds, which this machine runs, and their
// names.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace salvo::solver {

enum class Isa { scalar, sse2, avx2, avx512, neon };

std::string_view name(Isa isa);
std::optional<Isa> isa_named(std::string_view name);

/// The instruction sets that are compiled in and that processor and operating system support,
/// narrowest first.
std::vector<Isa> available_isas();

/// Throws std::invalid_argument when `isa` is not one of them.
void require_available(Isa isa);

/// The widest of them.
Isa widest_isa();

}  // namespace salvo::solver
