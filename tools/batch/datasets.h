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

/// In the order of the words, those of a folder or glob by name; a capture that is meant twice is
/// taken once. Of a glob what is no capture is left out, with a warning. Errors: InputError: no
/// such folder, no capture in it, a glob without a capture, two captures of one name, a name that
/// cannot be a folder of results.
std::vector<Dataset> find_datasets(const std::vector<std::string>& words);

}  // namespace tessera
