// Starts this program with other arguments, and ends it.
#include "tools/live/view_child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <string>
#include <thread>

#include "kernels/base/errors.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"

namespace tessera {

ViewChild::ViewChild(const std::filesystem::path& shown) {
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&files);
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, STDERR_FILENO, STDOUT_FILENO);
  std::string program = "tessera", command = "view", path = shown.string();
  char* const words[] = {program.data(), command.data(), path.data(), nullptr};
  const int error = posix_spawn(&child_, "/proc/self/exe", &files, &attributes, words, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0)
    throw InputError(
        fmt::format("--view: tessera view cannot be started: {}", std::strerror(error)));
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
