// A folder of results whose files are listed in a manifest, so that a later run replaces only
// these. New files are written to a hidden folder inside and moved to their places at the end;
// until then the earlier files stay as they are, and other files are never changed.
#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"

namespace tessera {

/// Whether the folder is there with contents, and without a manifest of `command` ("export").
/// Errors: InputError: a damaged manifest.
bool has_foreign_contents(const std::filesystem::path& folder, const std::string& command);

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
  /// A further file, of a name that was not known before it was written.
  void add(std::string file) { files_.push_back(std::move(file)); }
  /// Gives the files their places, removes those of an earlier run that are not among them, marks
  /// the manifest as complete. A kill in between leaves a manifest that is marked as not complete.
  void finish();

  /// Calls `write`, which makes the files. Errors: those of `write`, in which the hidden folder,
  /// which is gone when they are read, stands as this folder.
  template <class Write>
  auto written(const Write& write) const {
    try {
      return write();
    } catch (const InputError& error) {
      throw InputError(in_place(error.what()));
    } catch (const WriteError& error) {
      throw WriteError(in_place(error.what()));
    }
  }

 private:
  std::string in_place(std::string message) const;
  void write_manifest(const std::filesystem::path& file, bool complete) const;

  std::filesystem::path folder_, staging_;
  std::string command_;
  std::vector<std::string> files_;
  std::vector<std::string> earlier_;  // that an earlier run listed
  bool made_folder_;
};

}  // namespace tessera
