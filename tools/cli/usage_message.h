// One line that says what is wrong with a command line, with the names that may have been meant,
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
