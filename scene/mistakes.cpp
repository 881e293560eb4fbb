#include "scene/mistakes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

namespace salvo::scene {

Mistakes::Mistakes(std::string path, std::string_view text, std::vector<std::string> overrides)
    : path_(std::move(path)), overrides_(std::move(overrides)) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines_.push_back(text.substr(0, end));
    if (lines_.back().ends_with('\r')) lines_.back().remove_suffix(1);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

void Mistakes::add(const Place& place, std::string problem, std::string hint) {
  mistakes_.push_back({place, std::move(problem), std::move(hint)});
}

std::vector<std::string> Mistakes::texts() const {
  std::vector<Mistake> sorted = mistakes_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Mistake& a, const Mistake& b) {
    const auto key = [](const Place& p) { return std::tuple(p.source, p.line, p.column); };
    return key(a.place) < key(b.place);
  });
  std::vector<std::string> texts;
  texts.reserve(sorted.size());
  for (const Mistake& mistake : sorted) texts.push_back(text_of(mistake));
  return texts;
}

std::string_view Mistakes::line(const Place& place) const {
  if (place.source > 0) return overrides_[static_cast<std::size_t>(place.source - 1)];
  const auto index = static_cast<std::size_t>(place.line - 1);
  return index < lines_.size() ? lines_[index] : std::string_view();
}

std::string Mistakes::text_of(const Mistake& mistake) const {
  const Place& place = mistake.place;
  if (place.line == 0) {
    return fmt::format("{}: error: {}{}{}", path_, mistake.problem,
                       mistake.hint.empty() ? "" : "\n  ", mistake.hint);
  }
  std::string shown(line(place));
  std::replace(shown.begin(), shown.end(), '\t', ' ');
  const std::string number = place.source == 0 ? fmt::format("{}", place.line) : "";
  const std::string margin = fmt::format("{:>3}", number);
  const std::string where = place.source == 0
                                ? fmt::format("{}:{}:{}", path_, place.line, place.column)
                                : fmt::format("--set {}", shown);
  const std::string carets(static_cast<std::size_t>(std::max(place.length, 1)), '^');
  return fmt::format("{}: error: {}\n{} | {}\n{} | {}{}{}{}", where, mistake.problem, margin, shown,
                     std::string(margin.size(), ' '),
                     std::string(static_cast<std::size_t>(std::max(place.column, 1) - 1), ' '),
                     carets, mistake.hint.empty() ? "" : " ", mistake.hint);
}

}  // namespace salvo::scene
