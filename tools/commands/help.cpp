// `tessera help`, `tessera version` and `tessera reference`: the options of the program as help, as
// pages, man pages, completion or JSON. `reference` is hidden from help: the build and the
// documentation call it.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "recon4d/options/nearest_name.h"
#include "tools/cli/command.h"
#include "tools/reference/reference.h"
#include "tools/session/version.h"

namespace tessera {
namespace {

struct ReferenceRequest {
  std::string form, folder;
};

int reference(const CLI::App& app, const ReferenceRequest& request) {
  const std::vector<CommandReference> commands = program_reference(app);
  const std::string& form = request.form;
  if (form == "markdown" || form == "man") {
    if (request.folder.empty())
      throw InputError(fmt::format("reference {}: name the output folder", form));
    for (const auto& [page, text] :
         form == "man" ? man_pages(commands) : markdown_pages(commands)) {
      const std::filesystem::path path = std::filesystem::path(request.folder) / page;
      std::filesystem::create_directories(path.parent_path());
      write_text_file(path, text);
    }
    return kExitDone;
  }
  std::string text;
  if (form == "json")
    text = reference_json(commands).dump(1) + "\n";
  else if (form == "bash")
    text = bash_completion(commands);
  else if (form == "zsh")
    text = zsh_completion(commands);
  else if (form == "fish")
    text = fish_completion(commands);
  else
    throw InputError(
        fmt::format("reference: unknown form '{}'{}", form,
                    known_names(form, {"json", "markdown", "man", "bash", "zsh", "fish"})));
  std::fputs(text.c_str(), stdout);
  return kExitDone;
}

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

void add_reference_command(CLI::App& app, Work& work) {
  const auto request = std::make_shared<ReferenceRequest>();
  CLI::App* command =
      app.add_subcommand("reference", "the options as json, markdown, man, bash, zsh or fish");
  command->group("");
  command->add_option("form", request->form, "json, markdown, man, bash, zsh or fish")->required();
  command->add_option("folder", request->folder, "output folder of markdown and man");
  command->callback(
      [request, &app, &work] { work = [request, &app] { return reference(app, *request); }; });
}

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
