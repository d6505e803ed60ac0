// Suffixes are resolved before CLI11 reads the number; what is no such number is left to its
// message.
#include "tools/cli/suffixes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>

#include "recon4d/options/option_value.h"

namespace tessera {
namespace {

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

std::string lower_case(std::string text) {
  for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

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
