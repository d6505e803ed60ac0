// `tessera reference`: the options of the program as pages, man pages, completion or JSON. Hidden
// from help: the build and the documentation call it.
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "recon4d/options/nearest_name.h"
#include "tools/cli/command.h"
#include "tools/reference/reference.h"

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
    std::filesystem::create_directories(request.folder);
    if (form == "man") {
      write_man_pages(commands, request.folder);
    } else {
      write_text_file(std::filesystem::path(request.folder) / "cli.md", cli_page(commands));
      write_text_file(std::filesystem::path(request.folder) / "presets.md", presets_page());
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

}  // namespace tessera
