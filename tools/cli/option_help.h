// The layout of --help and --help-all.
#pragma once
#include <memory>

#include "tools/cli/command.h"

namespace tessera {

/// Two columns, wrapped to the terminal (80 to 110 characters; 100 where there is none), with the
/// default of each option in brackets. --help leaves out the options of the table that are not
/// `common` and prints their number; --help-all has them, by groups. Set it before commands are
/// added.
std::shared_ptr<CLI::Formatter> help_formatter();

}  // namespace tessera
