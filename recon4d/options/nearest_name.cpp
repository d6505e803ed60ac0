// Edit distance, matching by prefix, and the sentence with the suggestions.
#include "recon4d/options/nearest_name.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace tessera {
namespace {

constexpr size_t kLettersPerMistake = 3;
constexpr size_t kShortestPrefix = 2;  // letters; one alone begins too many names

/// Without the dashes of an option.
size_t letters(const std::string& typed) {
  const size_t first = typed.find_first_not_of('-');
  return first == std::string::npos ? 0 : typed.size() - first;
}

std::vector<std::string> names_with_prefix(const std::string& typed,
                                           const std::vector<std::string>& known) {
  std::vector<std::string> names;
  if (letters(typed) < kShortestPrefix) return names;
  for (const std::string& name : known)
    if (name.starts_with(typed)) names.push_back(name);
  return names;
}

}  // namespace

size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<size_t>> distance(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i) distance[i][0] = i;
  for (size_t j = 0; j <= b.size(); ++j) distance[0][j] = j;
  for (size_t i = 1; i <= a.size(); ++i)
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t replaced = distance[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      size_t& least = distance[i][j];
      least = std::min({replaced, distance[i - 1][j] + 1, distance[i][j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        least = std::min(least, distance[i - 2][j - 2] + 1);
    }
  return distance[a.size()][b.size()];
}

std::string nearest_name(const std::string& typed, const std::vector<std::string>& known) {
  const auto nearest =
      std::min_element(known.begin(), known.end(), [&](const std::string& a, const std::string& b) {
        return edit_distance(typed, a) < edit_distance(typed, b);
      });
  if (nearest == known.end()) return "";
  return edit_distance(typed, *nearest) <= letters(typed) / kLettersPerMistake ? *nearest : "";
}

std::string did_you_mean(const std::string& typed, const std::vector<std::string>& known) {
  const std::vector<std::string> names = names_with_prefix(typed, known);
  if (names.size() > 1) return fmt::format("; did you mean one of {}?", fmt::join(names, ", "));
  const std::string name = names.empty() ? nearest_name(typed, known) : names.front();
  return name.empty() ? "" : fmt::format("; did you mean '{}'?", name);
}

std::string known_names(const std::string& typed, const std::vector<std::string>& known) {
  const std::string suggestion = did_you_mean(typed, known);
  return fmt::format("{} are {}", suggestion.empty() ? "; there" : suggestion + " There",
                     fmt::join(known, ", "));
}

}  // namespace tessera
