// Runs the built `tessera` program as a child process with arguments and returns exit code, stdout
// and stderr. No shell is involved.
#pragma once
#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace tessera::testing {

struct ChildResult {
  int exit_code = -1;  // −1 when a signal ended it
  int signal = 0;
  std::string out, err;  // stdout, stderr
};

struct ChildLimits {
  /// Largest file it may write, bytes; writing more fails like a full disk (EFBIG), no signal.
  std::optional<uint64_t> file_bytes;
};

/// A program that runs until it is waited for; killed when that does not happen.
class ChildProcess {
 public:
  ChildProcess(const std::vector<std::string>& arguments, const std::filesystem::path& scratch,
               const ChildLimits& limits = {});
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ~ChildProcess();

  void send(int signal) const;
  bool running();
  /// Polls until `condition` holds. False when the program ends or two minutes pass before.
  bool wait_until(const std::function<bool()>& condition);
  ChildResult wait();
  /// What it has written to stdout and to stderr.
  std::string out_so_far() const;
  std::string err_so_far() const;

 private:
  std::filesystem::path out_, err_;
  pid_t pid_ = -1;
  std::optional<int> status_;
};

}  // namespace tessera::testing
