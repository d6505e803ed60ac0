// Runs `tessera view` beside a training, for --view. By a pipe the view passes its address on.
#pragma once
#include <sys/types.h>

#include <filesystem>
#include <string>

#include "tools/cli/command.h"
#include "tools/view/served_file.h"

namespace tessera {

struct ViewOptions {
  bool view = false;        // in a browser, from the first step on
  bool no_browser = false;  // its address alone
};
void add_view_options(CLI::App& command, ViewOptions& options);

/// In a process group of its own: Ctrl-C stops the training, and the view ends with its owner.
class ViewChild {
 public:
  /// Of an OUT of `tessera run` or a run folder, which a training writes now. `resumed_by`: the
  /// command that resumes the training, for the page. Prints the address on stderr, also with
  /// --quiet. Errors: InputError: it cannot be started.
  ViewChild(const std::filesystem::path& shown, const std::string& resumed_by,
            const ViewOptions& options);
  ViewChild(const ViewChild&) = delete;
  ViewChild& operator=(const ViewChild&) = delete;
  /// Ends it.
  ~ViewChild();

  /// After the training, of which `what` tells: at a terminal until Ctrl-C, so that it can be
  /// looked at; else as long as the page takes to learn of it.
  void serve(const std::string& what) const;

 private:
  bool has_ended() const;

  OpenFile from_view_;  // a line with its address
  std::string address_;
  pid_t child_ = -1;
};

}  // namespace tessera
