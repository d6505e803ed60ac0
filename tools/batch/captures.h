// Captures of a batch by the words of a command line: folders, folders of captures, globs.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/ingest.h"

namespace tessera {

struct Dataset {
  std::string name;                 // names the results: that of the folder, in safe characters
  std::filesystem::path path;       // absolute
  std::string split = {};           // that is scored; "": what is held out
  bool has_own_test_views = false;  // or is a rig, of which whole cameras are held out
};

/// In the order of the words, those of a folder or glob by name; a folder that is meant twice is
/// taken once; `out`, where the results go, is none of them. A word may end in :test, :val or
/// :train, the split that is scored. A folder that is no capture is taken, too, and fails alone.
/// Errors: InputError: no such folder, a glob that no folder matches, no capture among all, two of
/// one name, a folder with two splits.
std::vector<Dataset> find_datasets(const std::vector<std::string>& words,
                                   const std::filesystem::path& out);

/// Folders that a pattern matches, without `out`. Errors: InputError: none.
std::vector<std::filesystem::path> folders_of_glob(const std::string& pattern,
                                                   const std::filesystem::path& out);

/// The name of a folder in letters, digits and _ . + -: others become one _ where they stand
/// together.
std::string safe_name(const std::string& name);

/// Whether --test-every cannot choose the test views of a capture that is read with `options`: a
/// rig of several cameras, a transforms capture with test frames. False where it cannot be read.
bool has_test_views_of_its_own(const std::filesystem::path& capture, const IngestOptions& options);

}  // namespace tessera
