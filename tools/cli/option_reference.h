// Options and commands of the program as values and text, for help, reference pages, man pages and
// shell completion.
#pragma once
#include <string>
#include <vector>

#include "recon4d/options/presets.h"
#include "recon4d/options/train_options.h"
#include "tools/cli/command.h"

namespace tessera {

struct OptionReference {
  std::vector<std::string> names;  // as typed: "-o", "--out"; of an argument: its name
  std::string placeholder;         // of the value; empty: takes none
  std::vector<std::string> choices;
  std::string doc;       // one line, or with indented lines of choices
  std::string defaults;  // text; empty: none
  std::string group;
  bool required = false, is_argument = false;
  const TrainOption* row = nullptr;  // of the option table; null: an option of the command alone
};

struct CommandReference {
  std::string name, doc;
  std::vector<OptionReference> options;  // arguments first
};

OptionReference option_reference(const CLI::Option& option);
CommandReference command_reference(const CLI::App& command);
/// The first line of a description; lists of presets and the like follow on others.
std::string first_line(const std::string& doc);
/// Commands in the order in which they were added.
std::vector<CommandReference> program_reference(const CLI::App& app);

/// "--max-gaussians", and "--carve, --no-carve" of a switch.
std::string option_names(const TrainOption& option);
/// The placeholder of a value: "N", "X", "SIZE", "{pair,velocity}"; empty for a switch.
std::string option_placeholder(const TrainOption& option);
/// "0 to 1"; empty where the type alone limits a value.
std::string option_range(const TrainOption& option);

/// What `balanced` uses for a rig (SceneFacts::rig); empty where it is the same as elsewhere.
std::string rig_default(const TrainOption& option);
/// Both in one line: "7000; fast 2000; rigs 9000".
std::string default_text(const TrainOption& option);

/// The key as an option is typed, without dashes in front: "max-gaussians".
std::string dashed(std::string key);

}  // namespace tessera
