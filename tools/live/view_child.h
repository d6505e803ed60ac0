// Runs `tessera view` beside a training, for --view.
#pragma once
#include <sys/types.h>

#include <filesystem>

namespace tessera {

/// In a process group of its own: Ctrl-C ends the training, and this ends with its owner. What it
/// prints goes to stderr.
class ViewChild {
 public:
  /// Of an OUT of `tessera run` or a run folder, which a training writes now. Errors: InputError:
  /// it cannot be started.
  explicit ViewChild(const std::filesystem::path& shown);
  ViewChild(const ViewChild&) = delete;
  ViewChild& operator=(const ViewChild&) = delete;
  /// Ends it.
  ~ViewChild();

  /// At a terminal: serves until Ctrl-C, so that the result can be looked at. Else returns at once.
  void serve() const;

 private:
  pid_t child_ = -1;
};

}  // namespace tessera
