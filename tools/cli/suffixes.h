// Numbers of command lines with suffixes: 10k, 2s, 50%.
#pragma once
#include "tools/cli/command.h"

namespace tessera {

/// Lets every whole number of every command take k and M, and every other number take %, and s, m
/// and h where it is a time in seconds. Call it once all commands are there. Rows of the option
/// table read their own suffixes.
void accept_suffixes(CLI::App& app);

}  // namespace tessera
