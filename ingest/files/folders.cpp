// Exchanges an old folder for a new one in one step where the file system supports it
// (RENAME_EXCHANGE), else by two renames. After a crash between the two renames no folder has the
// target name.
#include "ingest/files/folders.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <string>
#include <system_error>
#include <vector>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

constexpr std::string_view kSuffix = ".partial";

std::string prefix_here(const std::string& stem) {
  return fmt::format(".{}.{}.", stem, host_name());
}

/// The process of this machine that has the name, or 0.
pid_t process_of(const std::string& name, const std::string& stem) {
  const std::string prefix = prefix_here(stem);
  if (!name.starts_with(prefix) || !name.ends_with(kSuffix)) return 0;
  const char* const end = name.data() + name.size() - kSuffix.size();
  pid_t process = 0;
  const auto [rest, error] = std::from_chars(name.data() + prefix.size(), end, process);
  return error == std::errc() && rest == end ? process : 0;
}

bool has_ended(pid_t process) {
  return ::kill(process, 0) != 0 && errno == ESRCH;
}

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& target, const std::string& seen) {
  throw InputError(fmt::format("{}: {}; choose another output folder", target.string(), seen));
}

[[noreturn]] void refuse(const fs::path& target, const char* seen, const std::error_code& reason) {
  if (!path_is_at_fault(reason.value())) fail_to_write(target, reason.value());
  refuse(target, fmt::format("{} ({})", seen, reason.message()));
}

/// Two renames, undone where the second fails; the old folder is at `staging` afterwards.
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
  if (!fs::is_directory(target)) refuse(target, "is a file, expected a folder");
  if (!may_replace && !fs::is_empty(target))
    refuse(target, "is a folder with other contents, it would be overwritten");
}

/// What to do with a file where a folder is expected, by its extension.
std::string advice_for_file(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? char(c + ('a' - 'A')) : c;
  const auto is_one_of = [&](std::initializer_list<const char*> endings) {
    return std::find(endings.begin(), endings.end(), ending) != endings.end();
  };
  if (is_one_of({".mp4", ".mkv", ".mov", ".avi", ".webm"}))
    return "is a video; put it into a folder of its own, with the other cameras' videos, and give "
           "that folder: tessera run FOLDER -o OUT";
  if (is_one_of({".ply", ".spz", ".splat", ".ckpt", ".t4d"}))
    return "is a model or a point cloud, not a capture; tessera info says what is in it";
  return "is a file; pass the folder that holds it";
}

}  // namespace

std::string staging_name(const std::string& stem) {
  return fmt::format("{}{}{}", prefix_here(stem), ::getpid(), kSuffix);
}

void remove_stale_staging(const std::filesystem::path& parent, const std::string& stem) {
  std::error_code ignored;
  std::vector<std::filesystem::path> stale;
  for (const auto& entry : std::filesystem::directory_iterator(parent, ignored)) {
    const pid_t process = process_of(entry.path().filename().string(), stem);
    if (process > 0 && has_ended(process)) stale.push_back(entry.path());
  }
  for (const std::filesystem::path& folder : stale) std::filesystem::remove_all(folder, ignored);
}

StagedFolder::StagedFolder(fs::path target, bool may_replace, std::set<std::string> owned)
    : target_(fs::absolute(target).lexically_normal()),
      may_replace_(may_replace),
      owned_(std::move(owned)) {
  if (target_.filename().empty()) target_ = target_.parent_path();  // a trailing slash
  if (fs::is_symlink(target_) && fs::is_directory(target_)) target_ = fs::canonical(target_);
  check_replaceable(target_, may_replace_);
  const std::string name = target_.filename().string();
  remove_stale_staging(target_.parent_path(), name);
  staging_ = target_.parent_path() / staging_name(name);
  std::error_code reason;
  fs::remove_all(staging_, reason);
  reason.clear();
  fs::create_directories(staging_, reason);
  if (reason) refuse(target_, "cannot be created", reason);
}

StagedFolder::~StagedFolder() {
  std::error_code ignored;
  if (!staging_.empty()) fs::remove_all(staging_, ignored);
}

void StagedFolder::carry_over() {
  if (owned_.empty()) return;
  std::error_code reason;
  std::vector<fs::path> others;
  for (fs::recursive_directory_iterator at(staging_, reason), end; !reason && at != end;
       at.increment(reason))
    if (const fs::path name = at->path().lexically_relative(staging_);
        (!at->is_directory() || at->is_symlink()) && !owned_.contains(name.generic_string()))
      others.push_back(name);
  for (const fs::path& name : others) {
    if (reason || fs::exists(target_ / name)) continue;
    fs::create_directories((target_ / name).parent_path(), reason);
    if (!reason) fs::rename(staging_ / name, target_ / name, reason);
  }
  if (!reason) return;
  const std::string kept = std::exchange(staging_, fs::path()).string();
  throw InputError(fmt::format(
      "{}: is replaced, but its other files could not be moved into it ({}); they are in {}",
      target_.string(), reason.message(), kept));
}

void StagedFolder::commit() {
  check(!staging_.empty(), "StagedFolder::commit twice");
  check_replaceable(target_, may_replace_);  // another program may have been faster
  std::error_code reason;
  if (fs::exists(target_)) {
    exchange(staging_, target_, reason);
    if (reason) refuse(target_, "cannot be replaced", reason);
    carry_over();
    fs::remove_all(staging_, reason);
  } else {
    fs::rename(staging_, target_, reason);
    if (reason) refuse(target_, "cannot be created", reason);
  }
  staging_.clear();
}

TemporaryFolder::TemporaryFolder(const std::string& purpose) {
  std::string name = (fs::temp_directory_path() / ("tessera_" + purpose + "_XXXXXX")).string();
  if (mkdtemp(name.data()) == nullptr) {
    if (!path_is_at_fault(errno)) fail_to_write(fs::temp_directory_path(), errno);
    throw InputError(name + ": cannot be made; set TMPDIR to a folder that can be written");
  }
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::filesystem::path find_entry(const std::filesystem::path& folder, const std::string& name,
                                 std::filesystem::file_type kind) {
  std::error_code unreachable;
  if (fs::status(folder / name, unreachable).type() == kind) return folder / name;
  for (const auto& entry : fs::directory_iterator(folder, unreachable)) {
    std::error_code unresolved;
    if (lower_case(entry.path().filename().string()) == lower_case(name) &&
        entry.status(unresolved).type() == kind)
      return entry.path();
  }
  return {};
}

void require_folder(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) return;
  if (std::filesystem::exists(path))
    throw InputError(fmt::format("{}: {}", path.string(), advice_for_file(path)));
  throw InputError(fmt::format("{}: no such folder; check the path", path.string()));
}

}  // namespace tessera
