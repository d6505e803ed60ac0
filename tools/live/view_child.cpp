// Starts this program with other arguments, and ends it.
#include "tools/live/view_child.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

#include "kernels/base/errors.h"
#include "tools/cli/background_program.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"

namespace tessera {

ViewChild::ViewChild(const std::filesystem::path& shown) {
  child_ = start_in_background("/proc/self/exe", {"tessera", "view", shown.string()},
                               ProgramOutput::kToStderr);
  if (child_ < 0)
    throw InputError(
        fmt::format("--view: tessera view cannot be started: {}", std::strerror(errno)));
}

ViewChild::~ViewChild() {
  ::kill(child_, SIGTERM);
  ::waitpid(child_, nullptr, 0);
}

void ViewChild::serve() const {
  if (::isatty(STDIN_FILENO) == 0 || interrupted()) return;
  say("view: the result can still be looked at; Ctrl-C ends it");
  while (!interrupted()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

}  // namespace tessera
