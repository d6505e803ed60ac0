// Runs `tessera view` beside a training, for --view. By a pipe the view passes its address on, and
// the requests of its page to resume the training.
#pragma once
#include <sys/types.h>

#include <filesystem>
#include <string>

#include "tools/view/served_file.h"

namespace tessera {

/// In a process group of its own: Ctrl-C stops the training, and the view ends with its owner.
class ViewChild {
 public:
  /// Of an OUT of `tessera run` or a run folder, which a training writes now. `by_hand`: the
  /// command that resumes the training in a terminal, for the page. Prints the address on stderr,
  /// also with
  /// --quiet. Errors: InputError: it cannot be started.
  ViewChild(const std::filesystem::path& shown, const std::string& by_hand);
  ViewChild(const ViewChild&) = delete;
  ViewChild& operator=(const ViewChild&) = delete;
  /// Ends it.
  ~ViewChild();

  /// After a training that has stopped before its end, of which `stopped` tells in a clause: serves
  /// until the page requests to resume it. False: Ctrl-C or another signal came first.
  bool serve_until_resumed(const std::string& stopped) const;
  /// After the end. At a terminal: serves until Ctrl-C, so that the result can be looked at. Else
  /// returns at once.
  void serve() const;

 private:
  bool read_request() const;

  OpenFile from_view_;  // a line with its address, then one for each request
  std::string by_hand_, address_;
  pid_t child_ = -1;
};

/// Whether somebody sits at a terminal, who can end what waits.
bool is_at_terminal();

}  // namespace tessera
