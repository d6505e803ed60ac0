// Folders become names of results.
#include "tools/batch/captures.h"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <map>
#include <utility>

#include "ingest/files/folders.h"
#include "ingest/layouts/capture_layout.h"
#include "kernels/base/errors.h"
#include "tools/cli/output_place.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> matches_of(const std::string& pattern) {
  glob_t found{};
  std::vector<fs::path> paths;
  if (::glob(pattern.c_str(), GLOB_BRACE | GLOB_TILDE, nullptr, &found) == 0)
    for (size_t i = 0; i < found.gl_pathc; ++i) paths.emplace_back(found.gl_pathv[i]);
  ::globfree(&found);
  return paths;
}

/// The folder itself, or those in it where these are captures, the broken ones among them too: one
/// stage says what is wrong with a capture, and that is ingest.
std::vector<fs::path> captures_at(const fs::path& folder, const fs::path& out) {
  return is_folder_of_captures(folder) ? subfolders(folder, out) : std::vector<fs::path>{folder};
}

std::vector<fs::path> captures_of_glob(const std::string& pattern, const fs::path& out) {
  std::vector<fs::path> captures;
  for (const fs::path& match : folders_of_glob(pattern, out))
    for (fs::path& capture : captures_at(match, out)) captures.push_back(std::move(capture));
  return captures;
}

/// Errors: InputError: none of them is a capture; with the reason of the first.
void check_any(const std::vector<Dataset>& datasets) {
  std::string why;
  for (const Dataset& dataset : datasets) {
    try {
      detect_layout(dataset.path);
      return;
    } catch (const AmbiguousCapture&) {  // its ingest options may decide
      return;
    } catch (const InputError& error) {
      if (why.empty()) why = error.what();
    }
  }
  throw InputError(why);
}

/// PATH and split of PATH:val; all of a word that names a folder is its path.
std::pair<std::string, std::string> path_and_split(const std::string& word) {
  const size_t colon = word.rfind(':');
  if (colon != std::string::npos && !fs::exists(word))
    for (const Split split : {Split::kTest, Split::kVal, Split::kTrain})
      if (word.substr(colon + 1) == name_of(split)) return {word.substr(0, colon), name_of(split)};
  return {word, ""};
}

}  // namespace

std::string safe_name(const std::string& name) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  std::string safe;
  bool replaced = false;
  for (const char c : name) {
    const bool stays = is_plain(c) || c == '.' || c == '+' || c == '-';
    if (stays || !replaced) safe += stays ? c : '_';
    replaced = !stays;
  }
  return !safe.empty() && is_plain(safe.front()) ? safe : "_" + safe;
}

std::vector<fs::path> folders_of_glob(const std::string& pattern, const fs::path& out) {
  const std::vector<fs::path> matches = matches_of(pattern);
  std::vector<fs::path> folders;
  for (const fs::path& match : matches)
    if (fs::is_directory(match) && !(fs::exists(out) && fs::equivalent(match, out)))
      folders.push_back(match);
  if (folders.empty())
    throw InputError(fmt::format(
        "{}: matches no folder ({} files match); correct the pattern, in quotes where the shell "
        "should leave it alone",
        pattern, matches.size()));
  return folders;
}

std::vector<Dataset> find_datasets(const std::vector<std::string>& words, const fs::path& out) {
  std::vector<Dataset> datasets;
  std::map<std::string, Dataset> by_name;
  for (const std::string& typed : words) {
    const auto& [word, split] = path_and_split(typed);
    const bool pattern = !fs::exists(word) && word.find_first_of("*?[{") != std::string::npos;
    if (!pattern) require_folder(word);
    for (const fs::path& path : pattern ? captures_of_glob(word, out) : captures_at(word, out)) {
      fs::path whole = fs::absolute(path).lexically_normal();
      if (!whole.has_filename()) whole = whole.parent_path();
      const Dataset dataset{safe_name(whole.filename().string()), whole, split};
      const auto [known, is_new] = by_name.emplace(dataset.name, dataset);
      if (is_new) {
        check_output_apart(out, whole);
        datasets.push_back(dataset);
      } else if (!fs::equivalent(known->second.path, whole)) {
        throw InputError(
            fmt::format("two captures are named '{}': {} and {}; rename one of the folders",
                        dataset.name, known->second.path.string(), whole.string()));
      } else if (known->second.split != split) {
        throw InputError(fmt::format("{}: is named with two splits; name it once", whole.string()));
      }
    }
  }
  check_any(datasets);
  return datasets;
}

bool has_test_views_of_its_own(const fs::path& capture, const IngestOptions& options) {
  try {
    IngestOptions of_layout = options;
    of_layout.layout = layout_of(capture, options);
    const LayoutRow& row = row_of(*of_layout.layout);
    if (row.photos) return false;
    const Capture read = row.read(capture, of_layout);
    const auto is_held_out = [](const CaptureFrame& f) { return f.frame.split != Split::kTrain; };
    return (read.clips.size() > 1 && options.cameras.size() != 1) ||
           std::any_of(read.frames.begin(), read.frames.end(), is_held_out);
  } catch (const InputError&) {
    return false;  // its preparation reports why
  }
}

}  // namespace tessera
