// What: the two renames that exchange an old folder for a new one, and their way back.
// Not: atomic between the two: after a crash there the old folder lies beside, under its own name.
#include "ingest/files/staged_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <system_error>
#include <vector>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

std::filesystem::path sibling(const std::filesystem::path& target, const char* purpose) {
  return target.parent_path() /
         fmt::format(".{}.{}.{}", target.filename().string(), ::getpid(), purpose);
}

[[noreturn]] void fail(const std::filesystem::path& target, const std::string& seen) {
  throw InputError(fmt::format("{}: {}; choose another output folder", target.string(), seen));
}

/// Whether `name` is ".TARGET.PID.PURPOSE" of a process that is no more.
bool is_of_ended_process(const std::string& name, const std::filesystem::path& target,
                         const std::string& purpose) {
  const std::string before = fmt::format(".{}.", target.filename().string());
  const std::string after = fmt::format(".{}", purpose);
  if (!name.starts_with(before) || !name.ends_with(after) ||
      name.size() <= before.size() + after.size())
    return false;
  const char* const end = name.data() + name.size() - after.size();
  pid_t process = 0;
  const auto [stopped, error] = std::from_chars(name.data() + before.size(), end, process);
  return error == std::errc() && stopped == end && process > 0 && ::kill(process, 0) != 0 &&
         errno == ESRCH;
}

/// A lock that the kernel gives back when its holder ends, on this machine or another that shares
/// the file system; −1 where there is none to be had.
int lock_of(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor >= 0 && ::flock(descriptor, LOCK_EX | LOCK_NB) == 0) return descriptor;
  if (descriptor >= 0) ::close(descriptor);
  return -1;
}

/// Removes what processes that were killed left beside `target`. A process number may belong to
/// another machine: a folder that cannot be locked is left alone.
void remove_abandoned(const std::filesystem::path& target) {
  std::error_code ignored;
  std::vector<std::filesystem::path> abandoned;
  const bool whole = std::filesystem::exists(target, ignored);
  for (const auto& entry : std::filesystem::directory_iterator(target.parent_path(), ignored)) {
    const std::string name = entry.path().filename().string();
    if (is_of_ended_process(name, target, "partial") ||
        (whole && is_of_ended_process(name, target, "replaced")))  // else it is the last one
      abandoned.push_back(entry.path());
  }
  for (const std::filesystem::path& folder : abandoned) {
    const int lock = lock_of(folder);
    if (lock < 0) continue;
    std::filesystem::remove_all(folder, ignored);
    ::close(lock);
  }
}

}  // namespace

StagedFolder::StagedFolder(std::filesystem::path target, bool may_replace)
    : target_(std::filesystem::absolute(target).lexically_normal()) {
  if (target_.filename().empty()) target_ = target_.parent_path();  // a trailing slash
  std::error_code reason;
  if (std::filesystem::exists(target_, reason)) {
    if (!std::filesystem::is_directory(target_)) fail(target_, "is a file, expected a folder");
    if (!may_replace && !std::filesystem::is_empty(target_))
      fail(target_, "is a folder with other contents, it would be overwritten");
  }
  remove_abandoned(target_);
  staging_ = sibling(target_, "partial");
  std::filesystem::remove_all(staging_, reason);
  reason.clear();
  std::filesystem::create_directories(staging_, reason);
  if (reason) fail(target_, fmt::format("cannot be created ({})", reason.message()));
  lock_ = lock_of(staging_);
}

StagedFolder::~StagedFolder() {
  std::error_code ignored;
  if (!staging_.empty()) std::filesystem::remove_all(staging_, ignored);
  if (lock_ >= 0) ::close(lock_);
}

void StagedFolder::commit() {
  check(!staging_.empty(), "StagedFolder::commit twice");
  const std::filesystem::path old = sibling(target_, "replaced");
  std::error_code reason;
  const bool replaces = std::filesystem::exists(target_);
  if (replaces) std::filesystem::rename(target_, old, reason);
  if (reason) fail(target_, fmt::format("cannot be replaced ({})", reason.message()));
  std::filesystem::rename(staging_, target_, reason);
  if (reason) {
    std::error_code ignored;
    if (replaces) std::filesystem::rename(old, target_, ignored);
    fail(target_, fmt::format("cannot be created ({})", reason.message()));
  }
  staging_.clear();
  std::filesystem::remove_all(old, reason);
}

}  // namespace tessera
