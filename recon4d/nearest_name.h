// What: the known name nearest to a mistyped one, for error messages that help.
// Not: completion; nothing is accepted that was not typed.
#pragma once
#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

namespace tessera {

/// Levenshtein distance.
inline size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<size_t> line(b.size() + 1);
  std::iota(line.begin(), line.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = line[0];
    line[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = line[j + 1];
      line[j + 1] = std::min({replaced, line[j] + 1, line[j + 1] + 1});
    }
  }
  return line[b.size()];
}

/// Errors: none; an empty list gives "".
inline std::string nearest_name(const std::string& typed, const std::vector<std::string>& known) {
  const auto nearest =
      std::min_element(known.begin(), known.end(), [&](const std::string& a, const std::string& b) {
        return edit_distance(typed, a) < edit_distance(typed, b);
      });
  return nearest == known.end() ? "" : *nearest;
}

}  // namespace tessera
