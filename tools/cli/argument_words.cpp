// Joins values to the switches before them.
#include "tools/cli/argument_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "tools/cli/option_text.h"

namespace tessera {
namespace {

bool is_switch(const std::string& word) {
  return std::any_of(
      train_option_table().begin(), train_option_table().end(),
      [&](const TrainOption& row) { return row.is_switch() && word == "--" + dashed(row.key); });
}

std::string dashed_name(const std::string& word) {
  if (!word.starts_with("--")) return word;
  const size_t equals = std::min(word.find('='), word.size());
  return dashed(word.substr(0, equals)) + word.substr(equals);
}

}  // namespace

std::string switch_complaint(const std::vector<std::string>& words) {
  constexpr const char* kReadable[] = {"true", "false", "yes", "no", "on", "off", "1", "0"};
  for (const std::string& word : words) {
    const size_t equals = word.find('=');
    if (equals == std::string::npos || !is_switch(dashed_name(word.substr(0, equals)))) continue;
    const std::string value = word.substr(equals + 1);
    if (std::find(std::begin(kReadable), std::end(kReadable), value) == std::end(kReadable))
      return fmt::format("{} is '{}', expected no value, true or false", word.substr(0, equals),
                         value);
  }
  return "";
}

std::vector<std::string> joined_switches(const std::vector<std::string>& words) {
  std::vector<std::string> joined;
  for (const std::string& word : words) {
    const bool is_truth = word == "true" || word == "false";
    if (is_truth && !joined.empty() && is_switch(joined.back()))
      joined.back() += "=" + word;
    else
      joined.push_back(dashed_name(word));
  }
  std::reverse(joined.begin(), joined.end());
  return joined;
}

}  // namespace tessera
