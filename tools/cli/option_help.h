// The layout of --help and --help-all.
#pragma once
#include <memory>
#include <string>

#include "tools/cli/command.h"

namespace tessera {

/// Two columns, wrapped to the terminal (80 to 110 characters; 100 where there is none), with the
/// default of each option in brackets. --help of a command with many options has some, examples,
/// and the number of the others; --help-all has all, by groups. Set it before commands are added.
std::shared_ptr<CLI::Formatter> help_formatter();

/// The first steps of a new user, a line each.
std::string first_steps();

}  // namespace tessera
