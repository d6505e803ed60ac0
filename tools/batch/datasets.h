// What: DATASET on the command line → captures with names: a capture, a folder of captures, a glob.
// Not: preparing them.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

struct Dataset {
  std::string name;            // of the folder; names the results
  std::filesystem::path path;  // absolute
};

/// In the order of the words, those of a folder or glob by name; a folder that is meant twice is
/// taken once; `out`, where the results go, is none of them. A folder that is no capture is taken,
/// too, and fails alone. Errors: InputError: no such folder, a glob that no folder matches, no
/// capture among all, two of one name, a name that cannot be a folder of results.
std::vector<Dataset> find_datasets(const std::vector<std::string>& words,
                                   const std::filesystem::path& out);

}  // namespace tessera
