// What: a prepared scene's folder appears whole or not at all: built beside its place, renamed.
// Not: a lock against two programs that write the same scene (tools/session/scene_lock.h).
#pragma once
#include <filesystem>

namespace tessera {

class StagedFolder {
 public:
  /// Creates a hidden sibling of `target` and removes those that killed programs have left.
  /// `may_replace` says whether a non-empty folder that is already there may be replaced (at
  /// `commit`, not before). Errors: InputError when it may not, when `target` is a file, or when
  /// its parent cannot be written; WriteError when the disk is full.
  StagedFolder(std::filesystem::path target, bool may_replace);
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;
  ~StagedFolder();

  /// Where to put the files until `commit`.
  const std::filesystem::path& path() const { return staging_; }
  /// Errors: as the constructor: what was there before stays then.
  void commit();

 private:
  std::filesystem::path target_, staging_;
  bool may_replace_;
};

}  // namespace tessera
