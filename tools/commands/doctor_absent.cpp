// `tessera doctor` of a build without ingest: an error that names the build option to set.
#include <memory>

#include "kernels/base/errors.h"
#include "tools/cli/command.h"

namespace tessera {

void add_doctor_command(CLI::App& app, Work& work) {
  CLI::App* command =
      app.add_subcommand("doctor", "check a capture or scene before hours are spent on it");
  const auto path = std::make_shared<std::string>();
  command->add_option("path", *path, "capture or prepared scene")->required();
  command->callback([&work, path] {
    work = [path]() -> int {
      throw InputError(*path +
                       ": this is the trainer-only build, which cannot look into images; run "
                       "doctor of a build configured with -DTESSERA_INGEST=ON");
    };
  });
}

}  // namespace tessera
