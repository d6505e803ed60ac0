// Reference pages, man pages and shell completion, made from the options of the program.
#pragma once
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/cli/option_reference.h"

namespace tessera {

/// {"version", "commands": [{"name", "doc", "options"}], "train_options": [{"key", "type", …}]}.
nlohmann::json reference_json(const std::vector<CommandReference>& commands);

/// Texts by file.
using ReferencePages = std::map<std::string, std::string>;
/// docs/reference: an index, a page a command, the training options, the presets.
ReferencePages markdown_pages(const std::vector<CommandReference>& commands);
/// tessera.1 and tessera-COMMAND.1.
ReferencePages man_pages(const std::vector<CommandReference>& commands);

/// Completion scripts: commands, options, choices of options, files for the rest.
std::string bash_completion(const std::vector<CommandReference>& commands);
std::string zsh_completion(const std::vector<CommandReference>& commands);
std::string fish_completion(const std::vector<CommandReference>& commands);

}  // namespace tessera
