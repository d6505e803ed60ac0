// What: open, flock, and a look whether the locked file still is the one of that name.
// Not: what is in the folder (run_folder.h).
#include "tools/session/run_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "kernels/base/errors.h"
#include "tools/session/locked_file.h"

namespace tessera {
namespace {

constexpr const char* kLockFile = "lock";

/// What the holder wrote of itself.
std::string holder(int descriptor) {
  std::array<char, 256> text{};
  const ssize_t bytes = ::pread(descriptor, text.data(), text.size() - 1, 0);
  return bytes > 0 ? std::string(text.data(), size_t(bytes)) : "another program";
}

}  // namespace

RunLock::RunLock(const std::filesystem::path& folder, SessionObserver& observer)
    : observer_(observer),
      file_(folder / kLockFile),
      made_folder_(!std::filesystem::exists(folder)) {
  make_folder(folder);
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
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) {
      const std::string who = holder(descriptor_);
      ::close(descriptor_);
      throw InputError(
          fmt::format("{}: {} is training in this folder; wait until it has ended or stop it, or "
                      "choose another folder",
                      file_.parent_path().string(), who));
    }
    observer_.on_warning(
        fmt::format("{}: this file system has no locks ({}); let no second training write here",
                    file_.string(), std::strerror(errno)));
    return true;
  }
  if (is_file_of_name(descriptor_, file_)) return true;
  ::close(descriptor_);
  return false;
}

bool is_run_locked(const std::filesystem::path& folder) {
  const int descriptor = ::open((folder / kLockFile).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool is_locked = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0;
  ::close(descriptor);
  return is_locked;
}

RunLock::~RunLock() {
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
  if (made_folder_) std::filesystem::remove(file_.parent_path(), ignored);  // only if it is empty
  ::close(descriptor_);
}

}  // namespace tessera
