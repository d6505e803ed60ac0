// Joins values to the switches before them, and reads numbers with suffixes.
#include "tools/cli/argument_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "kernels/base/lower_case.h"
#include "recon4d/options/option_value.h"
#include "tools/cli/option_reference.h"

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

bool is_time(const CLI::Option& option) {
  return option.check_lname("start") || option.check_lname("duration") ||
         option.check_lname("seconds");
}

/// The number that a text with a suffix states, as text; unchanged otherwise.
std::string plain_number(const std::string& text, Unit unit) {
  if (text.ends_with('%')) {
    const auto percent = parse_quantity(text.substr(0, text.size() - 1), Unit::kNone);
    return percent ? fmt::format("{}", *percent / 100) : text;
  }
  const auto number = parse_quantity(text, unit);
  return number ? fmt::format("{}", *number) : text;
}

std::string whole_number(const std::string& text) {
  const auto number = parse_quantity(text, Unit::kCount);
  const bool is_whole = number && *number == std::floor(*number) && std::abs(*number) < 1e15;
  return is_whole ? fmt::format("{:.0f}", *number) : text;
}

/// Options of a command whose values are names.
bool is_choice(const CLI::Option& option) {
  constexpr const char* kChoices[] = {"preset",     "format", "layout", "sync",
                                      "intrinsics", "cloud",  "split",  "backend"};
  return std::any_of(std::begin(kChoices), std::end(kChoices),
                     [&](const char* name) { return option.check_lname(name); });
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

void accept_suffixes(CLI::App& app) {
  for (CLI::App* command : app.get_subcommands({}))
    for (CLI::Option* option : command->get_options()) {
      if (is_choice(*option)) {
        option->transform([](const std::string& text) { return lower_case(text); });
        continue;
      }
      const std::string type = option->get_type_name();
      const bool is_whole = type.starts_with("INT") || type.starts_with("UINT");
      if (!is_whole && !type.starts_with("FLOAT")) continue;
      const Unit unit = is_time(*option) ? Unit::kSeconds : Unit::kNone;
      option->transform([is_whole, unit](std::string text) {
        return is_whole ? whole_number(text) : plain_number(text, unit);
      });
    }
}

}  // namespace tessera
