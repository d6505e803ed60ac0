// Folders that appear whole or not at all, temporary folders, and the check that an input path is a
// folder. A folder is built beside its target under a name with host and process, then renamed.
#pragma once
#include <unistd.h>

#include <array>
#include <filesystem>
#include <set>
#include <string>

namespace tessera {

inline std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown host";
}

/// ".STEM.HOST.PID.partial", the name for a folder of this process.
std::string staging_name(const std::string& stem);

/// Removes the folders for `stem` below `parent` whose process, of this machine, has ended.
void remove_stale_staging(const std::filesystem::path& parent, const std::string& stem);

class StagedFolder {
 public:
  /// Creates a hidden sibling of `target` and removes those that killed programs have left.
  /// `may_replace`: whether a non-empty folder that is already there may be replaced (at
  /// `commit`, not before). Errors: InputError when it may not, when `target` is a file, or when
  /// its parent cannot be written; WriteError when the disk is full. `owned`: relative names of the
  /// files that go with a folder that is replaced, where others are to stay; empty: all go. A link
  /// to a folder stays one.
  StagedFolder(std::filesystem::path target, bool may_replace, std::set<std::string> owned = {});
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;
  ~StagedFolder();

  /// Where to put the files until `commit`.
  const std::filesystem::path& path() const { return staging_; }
  /// Errors: as the constructor: what was there before stays then.
  void commit();

 private:
  /// What is not owned, from the folder that was replaced.
  void carry_over();

  std::filesystem::path target_, staging_;
  bool may_replace_;
  std::set<std::string> owned_;
};

class TemporaryFolder {
 public:
  /// Only its owner can enter it; `purpose` is a part of its name. Errors: InputError or WriteError
  /// where there is no place for it.
  explicit TemporaryFolder(const std::string& purpose);
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The entry of `folder` called `name`, else the first one whose name differs in case alone; empty
/// where there is none of that kind. Links are followed. Errors: none.
std::filesystem::path find_entry(const std::filesystem::path& folder, const std::string& name,
                                 std::filesystem::file_type kind);

/// Errors: InputError: nothing is at `path`, or a file.
void require_folder(const std::filesystem::path& path);

}  // namespace tessera
