// Values of command lines as people type them: 10k, 2s, 50%, FAST.
#pragma once
#include "tools/cli/command.h"

namespace tessera {

/// Lets every whole number of every command take k and M, and every other number take %, and s, m
/// and h where it is a time in seconds. Names of presets, formats and other choices ignore case.
/// Call it once all commands are there. Rows of the option table read their own suffixes.
void accept_suffixes(CLI::App& app);

}  // namespace tessera
