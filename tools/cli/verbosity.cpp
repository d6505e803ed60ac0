// Verbosity is set while the command line is parsed, before any work.
#include "tools/cli/verbosity.h"

#include "tools/cli/terminal.h"

namespace tessera {

void add_verbosity(CLI::App& app) {
  const auto every_command = [](const CLI::App*) { return true; };
  for (CLI::App* command : app.get_subcommands(every_command)) {
    CLI::Option* const quiet = command->add_flag_callback(
        "-q,--quiet", [] { set_verbosity(Verbosity::kQuiet); }, "print warnings and errors only");
    command
        ->add_flag_callback(
            "-v,--verbose", [] { set_verbosity(Verbosity::kVerbose); }, "also print details")
        ->excludes(quiet);
  }
}

}  // namespace tessera
