// Describes an error of the command line in one line, with similar names of options and commands,
// also those of other programs.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace tessera {

/// Whether words were typed and none of them is a command, as in `tessera trian --help`.
bool names_no_command(const CLI::App& app);

/// After `app` failed to parse, or names no command.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error);

}  // namespace tessera
