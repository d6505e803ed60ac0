// Unknown commands and options are looked up by name, and for a value that cannot be read the
// expected type is named. All other messages are those of CLI11.
#include "tools/cli/usage_message.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>

#include "recon4d/options/nearest_name.h"
#include "tools/cli/option_help.h"

namespace tessera {
namespace {

struct Advice {
  const char *command, *typed, *text;
};
constexpr Advice kAdvice[] = {
    {"run", "--resume", "run resumes by itself: repeat the command"},
    {"batch", "--resume", "batch resumes by itself: repeat the command"},
};

struct OtherName {
  const char *typed, *ours;
};
constexpr OtherName kOtherNames[] = {
    {"-p", "--preset"},           {"-j", "--threads"},           {"--jobs", "--threads"},
    {"--device", "--backend"},    {"--output", "--out"},         {"--output-dir", "--out"},
    {"--force", "--overwrite"},   {"--steps", "--iterations"},   {"--max-steps", "--iterations"},
    {"--epochs", "--iterations"}, {"--load-config", "--config"},
};

/// What to do instead of the unknown option `typed` of `command`; "" where nothing is known.
std::string usage_advice(const std::string& command, const std::string& typed) {
  for (const Advice& row : kAdvice)
    if (command == row.command && typed == row.typed) return row.text;
  return "";
}

/// Our name of an option that others call `typed`; "" where nothing is known.
std::string our_option_name(const std::string& typed) {
  for (const OtherName& row : kOtherNames)
    if (typed == row.typed) return row.ours;
  return "";
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

/// The commands that have an option of that name.
std::vector<std::string> commands_with(const CLI::App& app, const std::string& name) {
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands({}))
    if (command->get_option_no_throw(name) != nullptr) commands.push_back(command->get_name());
  return commands;
}

/// "; …": what may have been meant by an option that `command` does not have.
std::string option_advice(const CLI::App& app, const CLI::App& command, const std::string& name) {
  if (const std::string advice = usage_advice(command.get_name(), name); !advice.empty())
    return "; " + advice;
  const std::string ours = our_option_name(name);
  if (!ours.empty() && command.get_option_no_throw(ours) != nullptr)
    return fmt::format("; did you mean '{}'?", ours);
  if (const std::string nearest = did_you_mean(name, option_names(command)); !nearest.empty())
    return nearest;
  if (const std::vector<std::string> others = commands_with(app, name); !others.empty())
    return fmt::format("; it is an option of {}", fmt::join(others, ", "));
  return fmt::format("; see tessera {} --help", command.get_name());
}

/// Where the output is a required option that is not given: "write -o OUT, or ".
std::string output_advice(const CLI::App& command, const std::string& typed) {
  const CLI::Option* const out = command.get_option_no_throw("--out");
  if (out == nullptr || out->count() > 0 || typed.empty()) return "";
  return fmt::format("for the output write -o {}, or ", typed);
}

std::string unknown_option(const CLI::App& app, const CLI::App& command, const std::string& typed) {
  if (!typed.starts_with('-'))
    return fmt::format("tessera {}: '{}' is one argument too many; {}see tessera {} --help",
                       command.get_name(), typed, output_advice(command, typed),
                       command.get_name());
  const std::string name = typed.substr(0, typed.find('='));
  return fmt::format("tessera {}: unknown option '{}'{}", command.get_name(), name,
                     option_advice(app, command, name));
}

std::string without_command(const CLI::App& app) {
  const std::vector<std::string> rest = app.remaining();
  const std::vector<std::string> names = command_names(app);
  if (rest.empty())
    return fmt::format("tessera: no command. To begin:\n{}All commands: tessera --help",
                       first_steps());
  if (rest.front().starts_with('-'))
    return fmt::format("tessera: unknown option '{}'{}; see tessera --help", rest.front(),
                       did_you_mean(rest.front(), option_names(app)));
  return fmt::format("tessera: unknown command '{}'{}", rest.front(),
                     known_names(rest.front(), names));
}

/// What the option's values are, from CLI11's name of their type.
const char* kind_of_values(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  if (type.starts_with("UINT")) return "a whole number of 0 or more";
  if (type.starts_with("INT")) return "a whole number";
  if (type.starts_with("FLOAT")) return "a number";
  return "no value, true or false";
}

/// "--threads is 'many', expected a whole number"; "" where CLI11's text is not of that form.
std::string unreadable_value(const CLI::App& command, const std::string& text) {
  constexpr std::string_view kBegin = "Could not convert: ", kBetween = " = ";
  const size_t equals = text.find(kBetween);
  if (!text.starts_with(kBegin) || equals == std::string::npos) return "";
  const std::string name = text.substr(kBegin.size(), equals - kBegin.size());
  const CLI::Option* option = command.get_option_no_throw(name);
  if (option == nullptr) return "";
  return fmt::format("{} is '{}', expected {}", name, text.substr(equals + kBetween.size()),
                     kind_of_values(*option));
}

/// "--out needs a value"; "" where CLI11's text is not of that form.
std::string missing_value(const std::string& text) {
  const size_t colon = text.find(": ");
  const bool missing = text.starts_with('-') && text.ends_with(" missing");
  return missing && colon != std::string::npos ? text.substr(0, colon) + " needs a value" : "";
}

std::string value_message(const CLI::App& command, const CLI::ParseError& error) {
  const std::string text = one_line(error.what());
  for (const std::string& message : {unreadable_value(command, text), missing_value(text)})
    if (!message.empty()) return message;
  return text;
}

}  // namespace

bool names_no_command(const CLI::App& app) {
  return app.get_subcommands().empty() && app.remaining_size() > 0;
}

std::string usage_message(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<CLI::App*> parsed = app.get_subcommands();
  if (parsed.empty()) return without_command(app);
  const CLI::App& command = *parsed.front();
  const std::vector<std::string> rest = command.remaining();
  if (!rest.empty()) return unknown_option(app, command, rest.front());
  return fmt::format("tessera {}: {}; see tessera {} --help", command.get_name(),
                     value_message(command, error), command.get_name());
}

}  // namespace tessera
