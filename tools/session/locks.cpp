// Locks are flock() on a file of the folder; /proc/locks names the processes that hold one.
#include "tools/session/locks.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockFile = "lock";

/// False where it was removed or exchanged between opening and locking.
bool is_file_of_name(int descriptor, const std::filesystem::path& file) {
  struct stat locked {
  }, named{};
  return ::fstat(descriptor, &locked) == 0 && ::stat(file.c_str(), &named) == 0 &&
         locked.st_ino == named.st_ino && locked.st_dev == named.st_dev;
}

/// What the holder wrote of itself.
std::string holder(int descriptor) {
  std::array<char, 256> text{};
  const ssize_t bytes = ::pread(descriptor, text.data(), text.size() - 1, 0);
  return bytes > 0 ? std::string(text.data(), size_t(bytes)) : "another program";
}

/// The file that makes the folder a scene; empty where there is none.
fs::path description_of(const fs::path& scene) {
  for (const char* name : {"transforms.json", "transforms_train.json"})
    if (std::error_code absent; fs::is_regular_file(scene / name, absent)) return scene / name;
  return {};
}

/// For writing where that is allowed: NFS grants exclusive locks on such descriptors only.
int open_description(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
  return descriptor >= 0 ? descriptor : ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
}

/// "process 12 on HOST"; programs of other machines are not known by number.
std::string holders_of(int descriptor) {
  struct stat locked {};
  if (::fstat(descriptor, &locked) != 0) return "another program";
  const std::string inode = fmt::format(":{}", locked.st_ino);
  std::vector<std::string> processes;
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    std::istringstream words(line);
    std::string number, kind, advisory, access, process, file;
    words >> number >> kind >> advisory >> access >> process >> file;
    if (kind == "FLOCK" && file.ends_with(inode)) processes.push_back(process);
  }
  if (processes.empty()) return "a program on another machine";
  return fmt::format("process {} on {}", fmt::join(processes, ", "), host_name());
}

/// Returns 0 or errno. What is_run_locked of another program holds is waited for, up to 1 s.
int lock_for_itself(int descriptor) {
  for (int tries = 100; ::flock(descriptor, LOCK_EX | LOCK_NB) != 0; --tries) {
    if (errno != EWOULDBLOCK || tries == 0) return errno;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return 0;
}

[[noreturn]] void refuse(const fs::path& scene, SceneLock::Use use, const std::string& who) {
  if (use == SceneLock::Use::kRead)
    throw InputError(fmt::format("{}: {} is replacing this scene; wait until it has ended",
                                 scene.string(), who));
  throw InputError(
      fmt::format("{}: {} has this scene in use; wait until it has ended or stop it, or choose "
                  "another folder with -o",
                  scene.string(), who));
}

}  // namespace

RunLock::RunLock(const std::filesystem::path& folder, SessionObserver& observer)
    : observer_(observer), file_(fs::absolute(folder / kLockFile).lexically_normal()) {
  lock();
}

/// Of the folder, which is made where there is none.
void RunLock::lock() {
  made_folder_ = !fs::exists(file_.parent_path());
  make_folder(file_.parent_path());
  while (!take()) {
  }
  const std::string text = fmt::format("process {} on {}", ::getpid(), host_name());
  if (::ftruncate(descriptor_, 0) != 0 ||
      ::pwrite(descriptor_, text.data(), text.size(), 0) != ssize_t(text.size()))
    observer_.on_warning(
        fmt::format("{}: cannot be written ({})", file_.string(), std::strerror(errno)));
}

/// False when the file was removed by its holder in the meantime.
bool RunLock::take() {
  descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor_ < 0) fail_to_write(file_, errno);
  if (const int error = lock_for_itself(descriptor_); error != 0) {
    if (error == EWOULDBLOCK) {
      const std::string who = holder(descriptor_);
      ::close(descriptor_);
      throw InputError(
          fmt::format("{}: {} is training in this folder; wait until it has ended or stop it, or "
                      "choose another folder",
                      file_.parent_path().string(), who));
    }
    observer_.on_warning(
        fmt::format("{}: this file system has no locks ({}); let no second training write here",
                    file_.string(), std::strerror(error)));
    return true;
  }
  if (is_file_of_name(descriptor_, file_)) return true;
  ::close(descriptor_);
  return false;
}

bool is_run_locked(const std::filesystem::path& folder) {
  const int descriptor = ::open((folder / kLockFile).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool is_locked = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(descriptor);
  return is_locked;
}

fs::path RunLock::make_room() {
  const fs::path folder = file_.parent_path();
  fs::path aside;
  for (int i = 1; aside.empty() || fs::exists(fs::symlink_status(aside)); ++i)
    aside = fmt::format("{}.{}", folder.string(), i);
  std::error_code reason;
  fs::rename(folder, aside, reason);
  if (reason) fail_to_write(aside, reason.value());
  fs::remove(aside / kLockFile, reason);
  ::close(std::exchange(descriptor_, -1));
  lock();
  observer_.on_message(fmt::format("{}: what was there is {} now; remove it when it is not needed",
                                   folder.string(), aside.string()));
  return aside;
}

RunLock::~RunLock() {
  std::error_code ignored;
  if (is_file_of_name(descriptor_, file_)) std::filesystem::remove(file_, ignored);
  if (made_folder_) std::filesystem::remove(file_.parent_path(), ignored);  // only if it is empty
  ::close(descriptor_);
}

SceneLock::SceneLock(const fs::path& scene, Use use) {
  const int kind = (use == Use::kRead ? LOCK_SH : LOCK_EX) | LOCK_NB;
  for (fs::path file; !(file = description_of(scene)).empty();) {
    descriptor_ = open_description(file);
    if (descriptor_ < 0) return;  // the scene's reader reports why
    if (::flock(descriptor_, kind) != 0) {
      if (errno != EWOULDBLOCK) return;  // no locks here
      const std::string who = holders_of(descriptor_);
      ::close(descriptor_);
      refuse(scene, use, who);
    }
    if (is_file_of_name(descriptor_, file)) return;
    ::close(std::exchange(descriptor_, -1));
  }
}

SceneLock::~SceneLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace tessera
