// What: a folder of results whose files are listed in a manifest, so that a later run knows which
//       files are its own to replace. They are built in a hidden folder inside and take their
//       places at the end: what was there before stays as it was until then.
// Not: a folder that is replaced as a whole (ingest/files/folders.h): other files in it are never
// touched.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

class OutputFolder {
 public:
  /// `files`: relative names of those that will be written. Errors: InputError when the folder has
  /// contents that no run listed and `overwrite` is false; InputError or WriteError when it cannot
  /// be written.
  OutputFolder(std::filesystem::path folder, const std::string& command,
               std::vector<std::string> files, bool overwrite);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  /// Without `finish` nothing has changed, and a folder that was made is gone.
  ~OutputFolder();

  /// Where the files go until `finish`.
  const std::filesystem::path& staging() const { return staging_; }
  std::filesystem::path path(const std::string& file) const { return staging_ / file; }
  /// Gives the files their places, removes those of an earlier run that are not among them, marks
  /// the manifest as complete. A kill in between leaves a manifest that is marked as not complete.
  void finish();

 private:
  void write_manifest(const std::filesystem::path& file, bool complete) const;

  std::filesystem::path folder_, staging_;
  std::string command_;
  std::vector<std::string> files_;
  std::vector<std::string> earlier_;  // that an earlier run listed
  bool made_folder_;
};

}  // namespace tessera
