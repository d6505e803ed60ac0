// Starts this program with other arguments, reads what it passes on, and ends it.
#include "tools/live/view_child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "kernels/base/errors.h"
#include "tools/cli/background_program.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"

namespace tessera {
namespace {

constexpr int kPollMilliseconds = 100;

/// Of a pipe, without its end; what came of it where the other side has ended.
std::string read_line(int descriptor) {
  std::string line;
  for (char c = 0;;) {
    const ssize_t bytes = ::read(descriptor, &c, 1);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes <= 0 || c == '\n') return line;
    line += c;
  }
}

}  // namespace

bool is_at_terminal() {
  return ::isatty(STDIN_FILENO) != 0;
}

ViewChild::ViewChild(const std::filesystem::path& shown, const std::string& by_hand)
    : by_hand_(by_hand) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) == 0) {
    from_view_ = OpenFile(ends[0]);
    const OpenFile of_child(ends[1]);
    child_ = start_in_background("/proc/self/exe",
                                 {"tessera", "view", shown.string(), "--resumed-by", by_hand},
                                 {.output = ends[1]});
  }
  if (child_ < 0)
    throw InputError(
        fmt::format("--view: tessera view cannot be started: {}", std::strerror(errno)));
  address_ = read_line(from_view_.descriptor());
  if (address_.empty()) return;  // it has reported why, and the training does without it
  report_error(fmt::format("view: {}", address_));
  say("view: Ctrl-C stops the training with a checkpoint and ends the view");
}

ViewChild::~ViewChild() {
  ::kill(child_, SIGTERM);
  ::waitpid(child_, nullptr, 0);
}

/// Waits for the next. False: a signal came first, or the view has ended.
bool ViewChild::read_request() const {
  pollfd view{from_view_.descriptor(), POLLIN, 0};
  while (!interrupted()) {
    if (::poll(&view, 1, kPollMilliseconds) <= 0) continue;
    return !read_line(view.fd).empty();
  }
  return false;
}

bool ViewChild::serve_until_resumed(const std::string& stopped) const {
  if (interrupted() || address_.empty()) return false;
  say(
      fmt::format("view: {}; {} still answers, and its page resumes the training; Ctrl-C ends the "
                  "view; to resume in a terminal: {}",
                  stopped, address_, by_hand_));
  return read_request();
}

void ViewChild::serve() const {
  if (!is_at_terminal() || interrupted() || address_.empty()) return;
  say(fmt::format("view: {} still shows the result; Ctrl-C ends the view", address_));
  while (read_request()) {  // nothing is left to resume
  }
}

}  // namespace tessera
