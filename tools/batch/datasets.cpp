// What: globs, folders of captures, and names that must differ.
// Not: the layouts of captures (ingest/ingest.h).
#include "tools/batch/datasets.h"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <map>

#include "ingest/files/folders.h"
#include "ingest/ingest.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"
#include "tools/batch/ingest_batch.h"
#include "tools/session/output_place.h"

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
  const std::vector<fs::path> matches = matches_of(pattern);
  for (const fs::path& match : matches) {
    if (!fs::is_directory(match) || (fs::exists(out) && fs::equivalent(match, out))) continue;
    for (fs::path& capture : captures_at(match, out)) captures.push_back(std::move(capture));
  }
  if (captures.empty())
    throw InputError(fmt::format(
        "{}: matches no folder ({} files match); correct the pattern, in quotes where the shell "
        "should leave it alone",
        pattern, matches.size()));
  return captures;
}

/// Errors: InputError: none of them is a capture; says of the first why.
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

/// Letters, digits and _ . + -: names become folders and words of command lines.
void check_name(const Dataset& dataset) {
  constexpr const char* kFirst = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
  const std::string& name = dataset.name;
  if (name.find_first_not_of(std::string(kFirst) + ".+-") != std::string::npos ||
      name.find_first_of(kFirst) != 0)
    throw InputError(fmt::format(
        "{}: '{}' cannot name a folder of results; rename the capture's folder to letters, digits "
        "and _ . + - (or link to it from such a name)",
        dataset.path.string(), name));
}

}  // namespace

std::vector<Dataset> find_datasets(const std::vector<std::string>& words, const fs::path& out) {
  std::vector<Dataset> datasets;
  std::map<std::string, fs::path> by_name;
  for (const std::string& word : words) {
    const bool pattern = !fs::exists(word) && word.find_first_of("*?[{") != std::string::npos;
    if (!pattern) require_folder(word);
    for (const fs::path& path : pattern ? captures_of_glob(word, out) : captures_at(word, out)) {
      fs::path whole = fs::absolute(path).lexically_normal();
      if (!whole.has_filename()) whole = whole.parent_path();
      const Dataset dataset{whole.filename().string(), whole};
      check_name(dataset);
      const auto [known, is_new] = by_name.emplace(dataset.name, whole);
      if (is_new) {
        check_output_apart(out, whole);
        datasets.push_back(dataset);
      } else if (!fs::equivalent(known->second, whole)) {
        throw InputError(
            fmt::format("two captures are named '{}': {} and {}; rename one of the folders",
                        dataset.name, known->second.string(), whole.string()));
      }
    }
  }
  check_any(datasets);
  return datasets;
}

bool has_test_views_of_its_own(const fs::path& capture, const IngestOptions& options) {
  try {
    switch (layout_of(capture, options)) {
      case CaptureLayout::kVideos:
      case CaptureLayout::kN3dv:
        return videos_in(capture).size() > 1 && options.cameras.size() != 1;
      case CaptureLayout::kSequences:
        return options.reading != ImageReading::kMoving && options.cameras.size() != 1;
      case CaptureLayout::kTransforms: {
        const std::vector<TransformsFrame> frames = read_transforms_capture(capture).frames;
        return std::any_of(frames.begin(), frames.end(), [](const TransformsFrame& frame) {
          return frame.split != Split::kTrain;
        });
      }
      default:
        return false;
    }
  } catch (const InputError&) {
    return false;  // its preparation says why
  }
}

}  // namespace tessera
