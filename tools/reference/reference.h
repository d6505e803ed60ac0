// Reference pages, man pages and shell completion, made from the options of the program.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/cli/option_reference.h"

namespace tessera {

/// {"version", "commands": [{"name", "doc", "options"}], "train_options": [{"key", "type", …}]}.
nlohmann::json reference_json(const std::vector<CommandReference>& commands);

/// docs/reference/cli.md: every command with its own options, then the training options by group.
std::string cli_page(const std::vector<CommandReference>& commands);
/// docs/reference/presets.md: what each preset is for and where it differs from the defaults.
std::string presets_page();

/// Writes tessera.1 and tessera-COMMAND.1 into `folder`, which exists.
void write_man_pages(const std::vector<CommandReference>& commands,
                     const std::filesystem::path& folder);

/// Completion scripts: commands, options, choices of options, files for the rest.
std::string bash_completion(const std::vector<CommandReference>& commands);
std::string zsh_completion(const std::vector<CommandReference>& commands);
std::string fish_completion(const std::vector<CommandReference>& commands);

}  // namespace tessera
