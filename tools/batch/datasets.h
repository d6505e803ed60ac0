// What: DATASET on the command line → captures with names: a capture, a folder of captures, a glob.
// Not: preparing them.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/ingest.h"

namespace tessera {

struct Dataset {
  std::string name;                 // of the folder; names the results
  std::filesystem::path path;       // absolute
  bool has_own_test_views = false;  // or is a rig, of which whole cameras are held out
};

/// In the order of the words, those of a folder or glob by name; a folder that is meant twice is
/// taken once; `out`, where the results go, is none of them. A folder that is no capture is taken,
/// too, and fails alone. Errors: InputError: no such folder, a glob that no folder matches, no
/// capture among all, two of one name, a name that cannot be a folder of results.
std::vector<Dataset> find_datasets(const std::vector<std::string>& words,
                                   const std::filesystem::path& out);

/// Whether --test-every cannot choose the test views of a capture that is read with `options`: a
/// rig of several cameras, a transforms capture with test frames. False where it cannot be read.
bool has_test_views_of_its_own(const std::filesystem::path& capture, const IngestOptions& options);

}  // namespace tessera
