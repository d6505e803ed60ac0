// What: the two renames that exchange an old folder for a new one, and their way back.
// Not: atomic between the two: after a crash there the old folder lies beside, under its own name.
#include "ingest/files/staged_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <system_error>

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
  staging_ = sibling(target_, "partial");
  std::filesystem::remove_all(staging_, reason);
  reason.clear();
  std::filesystem::create_directories(staging_, reason);
  if (reason) fail(target_, fmt::format("cannot be created ({})", reason.message()));
}

StagedFolder::~StagedFolder() {
  std::error_code ignored;
  if (!staging_.empty()) std::filesystem::remove_all(staging_, ignored);
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
