// What: a folder of results whose files are listed in a manifest, so that a later run knows which
//       files are its own to replace.
// Not: a folder that appears as a whole (staged_folder.h): an interrupted run keeps what is done.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

class OutputFolder {
 public:
  /// Creates `folder`, removes the files an earlier run listed there, lists `files` (relative
  /// names). Errors: InputError when the folder has contents that no run listed and `overwrite` is
  /// false, or cannot be written. Other files are never removed.
  OutputFolder(std::filesystem::path folder, const std::string& command,
               std::vector<std::string> files, bool overwrite);

  std::filesystem::path path(const std::string& file) const { return folder_ / file; }
  /// Marks the manifest as complete.
  void finish();

 private:
  void write_manifest(bool complete) const;

  std::filesystem::path folder_;
  std::string command_;
  std::vector<std::string> files_;
};

}  // namespace tessera
