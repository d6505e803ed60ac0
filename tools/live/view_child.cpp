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
#include <vector>

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

void add_view_options(CLI::App& command, ViewOptions& options) {
  command.add_flag("--view", options.view,
                   "show the training in a browser: tessera view of the output");
  command.add_flag("--no-browser", options.no_browser, "with --view: print the address only");
}

ViewChild::ViewChild(const std::filesystem::path& shown, const std::string& resumed_by,
                     const ViewOptions& options) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) == 0) {
    from_view_ = OpenFile(ends[0]);
    const OpenFile of_child(ends[1]);
    std::vector<std::string> words{"tessera", "view", shown.string(), "--resumed-by", resumed_by};
    if (options.no_browser) words.push_back("--no-browser");
    child_ = start_in_background("/proc/self/exe", words, {.output = ends[1]});
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

/// Waits a while for it.
bool ViewChild::has_ended() const {
  pollfd view{from_view_.descriptor(), POLLIN, 0};
  return ::poll(&view, 1, kPollMilliseconds) > 0;  // it writes nothing more
}

void ViewChild::serve(const std::string& what) const {
  constexpr int kPolls = 30;  // a page asks once a second
  if (interrupted() || address_.empty()) return;
  const bool is_watched = ::isatty(STDIN_FILENO) != 0;
  if (is_watched) say(fmt::format("view: {} still shows {}; Ctrl-C ends the view", address_, what));
  for (int i = 0; (is_watched || i < kPolls) && !interrupted() && !has_ended(); ++i) {
  }
}

}  // namespace tessera
