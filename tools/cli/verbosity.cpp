// What: Sets the verbosity of the terminal while the command line is parsed, before any work.
// Not: flags of the program itself, before the command.
#include "tools/cli/verbosity.h"

#include "tools/cli/terminal.h"

namespace tessera {

void add_verbosity(CLI::App& app) {
  const auto every_command = [](const CLI::App*) { return true; };
  for (CLI::App* command : app.get_subcommands(every_command)) {
    CLI::Option* const quiet = command->add_flag_callback(
        "-q,--quiet", [] { set_verbosity(Verbosity::kQuiet); },
        "print no progress and no messages but warnings and errors");
    command
        ->add_flag_callback(
            "-v,--verbose", [] { set_verbosity(Verbosity::kVerbose); },
            "also print details, e.g. SSIM with each kind of padding")
        ->excludes(quiet);
  }
}

}  // namespace tessera
