// What: a prepared scene's folder appears whole or not at all: built beside its place, renamed.
// Not: a lock against two programs that write the same scene.
#pragma once
#include <filesystem>

namespace tessera {

class StagedFolder {
 public:
  /// Creates a hidden sibling of `target`, and removes those of processes that were killed.
  /// `may_replace` says whether a non-empty folder that is already there may be replaced (at
  /// `commit`, not before). Errors: InputError when it may not, when `target` is a file, or when
  /// its parent cannot be written.
  StagedFolder(std::filesystem::path target, bool may_replace);
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;
  ~StagedFolder();

  /// Where to put the files until `commit`.
  const std::filesystem::path& path() const { return staging_; }
  void commit();

 private:
  std::filesystem::path target_, staging_;
  int lock_ = -1;  // on staging_: says to others that its process lives
};

}  // namespace tessera
