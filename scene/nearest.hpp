// What a mistyped word may have meant: the known word at the least edit distance.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace salvo::scene {

/// Insertions, deletions, replacements and swaps of neighbours that turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The nearest candidate (the first of equals), or "" when none is near: more than a third of the
/// letters would change.
std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates);

/// `did you mean "speed"?`, or "" when no candidate is near.
std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates);

}  // namespace salvo::scene
