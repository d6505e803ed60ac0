// Starts the child with posix_spawn in a separate process group, with one pipe for its output and
// /dev/null as its input. A guard ends the process group.
#include "ingest/files/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <thread>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"

extern char** environ;

namespace tessera {
namespace {

constexpr int kSilenceMs = 100;                   // between two checks of a child without output
constexpr auto kGrace = std::chrono::seconds(1);  // between SIGTERM and SIGKILL

/// The child and its group; both are gone when this is.
class ProcessGroup {
 public:
  explicit ProcessGroup(pid_t leader) : leader_(leader) {}
  ProcessGroup(const ProcessGroup&) = delete;
  ProcessGroup& operator=(const ProcessGroup&) = delete;
  ~ProcessGroup() {
    if (!ended_) {
      ::kill(-leader_, SIGTERM);
      const auto until = std::chrono::steady_clock::now() + kGrace;
      while (!has_exited() && std::chrono::steady_clock::now() < until)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ::kill(-leader_, SIGKILL);  // the id stays taken until the leader is reaped
    int status = 0;
    while (::waitpid(leader_, &status, 0) < 0 && errno == EINTR) {
    }
  }

  /// Looks without reaping, so that the group's id is not given to another.
  bool has_exited() {
    siginfo_t info{};
    if (!ended_ && ::waitid(P_PID, id_t(leader_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
        info.si_pid == leader_) {
      ended_ = true;
      exit_code_ = info.si_code == CLD_EXITED ? info.si_status : 128 + info.si_status;
    }
    return ended_;
  }
  int exit_code() const { return exit_code_; }

 private:
  pid_t leader_;
  bool ended_ = false;
  int exit_code_ = 0;
};

struct Descriptor {
  int number = -1;
  Descriptor() = default;
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }
  void close() {
    if (number >= 0) ::close(number);
    number = -1;
  }
};

std::vector<std::string> environment_of(const ChildCommand& command) {
  std::vector<std::string> entries;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    bool replaced = false;
    for (const auto& [name, value] : command.environment)
      replaced = replaced || text.starts_with(name + "=");
    if (!replaced) entries.emplace_back(text);
  }
  for (const auto& [name, value] : command.environment) entries.push_back(name + "=" + value);
  return entries;
}

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

pid_t spawn(const ChildCommand& command, int output) {
  std::vector<std::string> arguments = command.arguments, environment = environment_of(command);
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, output, 1);
  posix_spawn_file_actions_adddup2(&files, output, 2);
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  pid_t child = 0;
  const int error = ::posix_spawn(&child, arguments[0].c_str(), &files, &attributes,
                                  pointers_to(arguments).data(), pointers_to(environment).data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0)
    throw InputError(fmt::format("{}: cannot be started ({}); check the file and its permissions",
                                 command.arguments[0], std::strerror(error)));
  return child;
}

/// The output of a child: kept in the log, cut into lines.
class ChildOutput {
 public:
  ChildOutput(const std::filesystem::path& log,
              const std::function<void(std::string_view)>& on_line)
      : on_line_(on_line), name_(log.string()) {
    if (log.empty()) return;
    log_.reset(std::fopen(log.c_str(), "ab"));
    if (log_ == nullptr) fail();
  }

  void add(std::string_view text) {
    if (log_ != nullptr && (std::fwrite(text.data(), 1, text.size(), log_.get()) != text.size() ||
                            std::fflush(log_.get()) != 0))
      fail();
    for (const char c : text) {
      if (c == '\n' || c == '\r')
        end_line();
      else
        line_ += c;
    }
  }
  void end_line() {
    if (line_.find_first_not_of(" \t") == std::string::npos) return line_.clear();
    last_line_ = std::move(line_);
    line_.clear();
    on_line_(last_line_);
  }
  std::string take_last_line() { return std::move(last_line_); }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  [[noreturn]] void fail() const { fail_to_write(name_, errno); }

  const std::function<void(std::string_view)>& on_line_;
  std::string name_, line_, last_line_;
  std::unique_ptr<std::FILE, Close> log_;
};

/// True while there may be more: the pipe is open and someone of the group may write.
bool read_some(int pipe, bool may_wait, ChildOutput& output) {
  pollfd waiting{pipe, POLLIN, 0};
  const int ready = ::poll(&waiting, 1, may_wait ? kSilenceMs : 0);
  if (ready <= 0) return may_wait;
  char block[4096];
  const ssize_t count = ::read(pipe, block, sizeof block);
  if (count < 0) return errno == EINTR;
  if (count > 0) output.add({block, size_t(count)});
  return count > 0;
}

}  // namespace

ChildResult run_child(const ChildCommand& command,
                      const std::function<void(std::string_view)>& on_line) {
  ChildOutput output(command.log, on_line);
  Descriptor ours, theirs;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    throw InputError(fmt::format("{}: no pipe to it ({}); close other programs",
                                 command.arguments[0], std::strerror(errno)));
  ours.number = ends[0];
  theirs.number = ends[1];
  ProcessGroup group(spawn(command, theirs.number));
  theirs.close();
  bool open = true;
  while (!group.has_exited()) {  // the group may close its output before it ends
    if (open)
      open = read_some(ours.number, true, output);
    else
      std::this_thread::sleep_for(std::chrono::milliseconds(kSilenceMs));
    on_line({});
  }
  while (open) open = read_some(ours.number, false, output);
  output.end_line();
  return {group.exit_code(), output.take_last_line()};
}

std::filesystem::path find_program(const std::string& name) {
  if (name.find('/') != std::string::npos)
    return ::access(name.c_str(), X_OK) == 0 ? std::filesystem::path(name)
                                             : std::filesystem::path();
  const char* stated = std::getenv("PATH");
  const std::string folders = stated == nullptr ? "" : stated;
  for (size_t begin = 0; begin <= folders.size();) {
    const size_t end = std::min(folders.find(':', begin), folders.size());
    const auto file = std::filesystem::path(folders.substr(begin, end - begin)) / name;
    std::error_code ignored;
    if (end > begin && std::filesystem::is_regular_file(file, ignored) &&
        ::access(file.c_str(), X_OK) == 0)
      return file;
    begin = end + 1;
  }
  return {};
}

}  // namespace tessera
