// What: unknown commands and options are looked up by name; the rest is CLI11's own text.
// Not: a second parse.
#include "tools/usage_message.h"

#include <fmt/format.h>

#include <algorithm>

#include "recon4d/nearest_name.h"

namespace tessera {
namespace {

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

std::string unknown_option(const CLI::App& command, const std::string& typed) {
  if (typed.front() != '-')
    return fmt::format("tessera {}: '{}' is one argument too many; see tessera {} --help",
                       command.get_name(), typed, command.get_name());
  const std::string name = typed.substr(0, typed.find('='));
  return fmt::format("tessera {}: unknown option '{}'; did you mean '{}'?", command.get_name(),
                     name, nearest_name(name, option_names(command)));
}

}  // namespace

std::string usage_message(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<CLI::App*> parsed = app.get_subcommands();
  if (parsed.empty()) {
    const std::vector<std::string> rest = app.remaining();
    const std::vector<std::string> names = command_names(app);
    if (rest.empty())
      return fmt::format("tessera: no command; choose one of {}", fmt::join(names, ", "));
    return fmt::format("tessera: unknown command '{}'; did you mean '{}'? There are {}",
                       rest.front(), nearest_name(rest.front(), names), fmt::join(names, ", "));
  }
  const CLI::App& command = *parsed.front();
  const std::vector<std::string> rest = command.remaining();
  if (!rest.empty()) return unknown_option(command, rest.front());
  return fmt::format("tessera {}: {}; see tessera {} --help", command.get_name(),
                     one_line(error.what()), command.get_name());
}

}  // namespace tessera
