// What: `tessera help [COMMAND]` and `tessera version`, for --help and --version.
// Not: the text of the help, which CLI11 makes of the options.
#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "kernels/base/errors.h"
#include "recon4d/options/nearest_name.h"
#include "tools/cli/command.h"
#include "tools/session/version.h"

namespace tessera {
namespace {

/// What `tessera COMMAND --help` prints; of the whole program where `name` is empty.
std::string help_text(const CLI::App& app, const std::string& name) {
  const auto mode = CLI::AppFormatMode::Normal;
  if (name.empty()) return app.get_formatter()->make_help(&app, app.get_name(), mode);
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->get_name() == name)
      return command->get_formatter()->make_help(command, app.get_name() + " " + name, mode);
    names.push_back(command->get_name());
  }
  throw InputError(fmt::format("help: unknown command '{}'{}", name, known_names(name, names)));
}

}  // namespace

void add_help_commands(CLI::App& app, Work& work) {
  const auto name = std::make_shared<std::string>();
  CLI::App* help = app.add_subcommand("help", "print the help of a command");
  help->add_option("command", *name, "to be explained; default: the program");
  help->callback([name, &app, &work] {
    work = [name, &app] {
      std::fputs(help_text(app, *name).c_str(), stdout);
      return int(kExitDone);
    };
  });
  app.add_subcommand("version", "print the version")->callback([&work] {
    work = [] {
      fmt::print("{}\n", kVersionText);
      return int(kExitDone);
    };
  });
}

}  // namespace tessera
