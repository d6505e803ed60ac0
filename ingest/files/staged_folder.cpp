// What: the exchange of an old folder for a new one: one step where the file system has it
//       (RENAME_EXCHANGE), else two renames and their way back.
// Not: atomic where it takes two: after a crash between them there is no folder of that name.
#include "ingest/files/staged_folder.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "ingest/files/staging.h"
#include "ingest/files/write_failure.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& target, const std::string& seen) {
  throw InputError(fmt::format("{}: {}; choose another output folder", target.string(), seen));
}

[[noreturn]] void fail(const fs::path& target, const char* seen, const std::error_code& reason) {
  if (!path_is_at_fault(reason.value())) fail_to_write(target, reason.value());
  fail(target, fmt::format("{} ({})", seen, reason.message()));
}

/// Renames with a way back; what was there is in `staging` afterwards.
void exchange_in_two_steps(const fs::path& staging, const fs::path& target,
                           std::error_code& reason) {
  const fs::path old = staging.string() + ".replaced";
  fs::rename(target, old, reason);
  if (reason) return;
  fs::rename(staging, target, reason);
  std::error_code ignored;
  fs::rename(old, reason ? target : staging, ignored);
}

void exchange(const fs::path& staging, const fs::path& target, std::error_code& reason) {
  if (::renameat2(AT_FDCWD, staging.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) == 0)
    return;
  if (errno != EINVAL && errno != ENOSYS && errno != ENOTSUP)
    reason.assign(errno, std::generic_category());
  else
    exchange_in_two_steps(staging, target, reason);
}

void check_replaceable(const fs::path& target, bool may_replace) {
  std::error_code unreachable;
  if (!fs::exists(target, unreachable)) return;
  if (!fs::is_directory(target)) fail(target, "is a file, expected a folder");
  if (!may_replace && !fs::is_empty(target))
    fail(target, "is a folder with other contents, it would be overwritten");
}

}  // namespace

StagedFolder::StagedFolder(fs::path target, bool may_replace)
    : target_(fs::absolute(target).lexically_normal()), may_replace_(may_replace) {
  if (target_.filename().empty()) target_ = target_.parent_path();  // a trailing slash
  check_replaceable(target_, may_replace_);
  const std::string name = target_.filename().string();
  remove_stale_staging(target_.parent_path(), name);
  staging_ = target_.parent_path() / staging_name(name);
  std::error_code reason;
  fs::remove_all(staging_, reason);
  reason.clear();
  fs::create_directories(staging_, reason);
  if (reason) fail(target_, "cannot be created", reason);
}

StagedFolder::~StagedFolder() {
  std::error_code ignored;
  if (!staging_.empty()) fs::remove_all(staging_, ignored);
}

void StagedFolder::commit() {
  check(!staging_.empty(), "StagedFolder::commit twice");
  check_replaceable(target_, may_replace_);  // another program may have been faster
  std::error_code reason;
  if (fs::exists(target_)) {
    exchange(staging_, target_, reason);
    if (reason) fail(target_, "cannot be replaced", reason);
    fs::remove_all(staging_, reason);
  } else {
    fs::rename(staging_, target_, reason);
    if (reason) fail(target_, "cannot be created", reason);
  }
  staging_.clear();
}

}  // namespace tessera
