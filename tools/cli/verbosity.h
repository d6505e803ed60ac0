// What: The two flags that every command has: --quiet and --verbose.
// Not: what they leave out or add (terminal.h, and the commands).
#pragma once
#include <CLI/CLI.hpp>

namespace tessera {

/// Adds -q/--quiet and -v/--verbose to every subcommand of the root `app`; they set the verbosity
/// of terminal.h. To be called once, after the commands are added.
void add_verbosity(CLI::App& app);

}  // namespace tessera
