// Child processes by fork, exec and wait (POSIX). Output is written to files, so that no pipe can
// block.
#include "tests/tools/commands/child_process.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "ingest/files/atomic_file.h"

namespace tessera::testing {
namespace {

/// In the child: never returns.
[[noreturn]] void become_program(const std::vector<std::string>& arguments, const char* out,
                                 const char* err, const ChildLimits& limits) {
  ::dup2(::open("/dev/null", O_RDONLY), STDIN_FILENO);
  ::dup2(::open(out, O_WRONLY | O_CREAT | O_TRUNC, 0644), STDOUT_FILENO);
  ::dup2(::open(err, O_WRONLY | O_CREAT | O_TRUNC, 0644), STDERR_FILENO);
  if (limits.file_bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{*limits.file_bytes, *limits.file_bytes};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  std::vector<char*> argv{const_cast<char*>(TESSERA_PROGRAM)};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  ::execv(TESSERA_PROGRAM, argv.data());
  std::_Exit(127);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& arguments,
                           const std::filesystem::path& scratch, const ChildLimits& limits)
    : out_(scratch / "child_stdout"), err_(scratch / "child_stderr") {
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error("fork failed");
  if (pid_ == 0) become_program(arguments, out_.c_str(), err_.c_str(), limits);
}

ChildProcess::~ChildProcess() {
  if (status_) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

void ChildProcess::send(int signal) const {
  ::kill(pid_, signal);
}

bool ChildProcess::running() {
  if (status_) return false;
  int status = 0;
  if (::waitpid(pid_, &status, WNOHANG) == pid_) status_ = status;
  return !status_;
}

bool ChildProcess::wait_until(const std::function<bool()>& condition) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::minutes(2);
  while (Clock::now() < end) {
    if (condition()) return true;
    if (!running()) return condition();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return false;
}

ChildResult ChildProcess::wait() {
  if (!status_) {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    status_ = status;
  }
  ChildResult result;
  if (WIFEXITED(*status_)) result.exit_code = WEXITSTATUS(*status_);
  if (WIFSIGNALED(*status_)) result.signal = WTERMSIG(*status_);
  result.out = read_text_file(out_);
  result.err = read_text_file(err_);
  return result;
}

std::string ChildProcess::out_so_far() const {
  return std::filesystem::exists(out_) ? read_text_file(out_) : "";
}

std::string ChildProcess::err_so_far() const {
  return std::filesystem::exists(err_) ? read_text_file(err_) : "";
}

}  // namespace tessera::testing
