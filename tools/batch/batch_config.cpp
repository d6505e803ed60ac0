// Finds captures and checks names, presets, options and formats.
#include "tools/batch/batch_config.h"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "ingest/files/folders.h"
#include "ingest/ingest.h"
#include "ingest/layouts/capture_layout.h"
#include "kernels/base/errors.h"
#include "recon4d/evaluation/evaluate.h"
#include "recon4d/options/nearest_name.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options.h"
#include "static3d/formats/splat_file.h"
#include "tools/batch/engine.h"
#include "tools/cli/argument_words.h"
#include "tools/cli/output_place.h"
#include "tools/export/formats.h"

namespace tessera {
namespace {

using nlohmann::json;

/// Errors: InputError naming the nearest known name.
void check_table(const std::string& name) {
  std::vector<std::string> names;
  for (const auto& [known, text] : workflow_tables()) names.push_back(known);
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw InputError(fmt::format("--table: unknown table '{}'{}", name, known_names(name, names)));
}

/// Presets and options as a training would take them. Errors: InputError.
void check_training(const BatchConfig& config) {
  if (!config.table.empty()) check_table(config.table);
  for (const std::string& preset : config.presets) {
    TrainOptions options;
    apply_preset(options, preset);
    for (const auto& [key, text] : config.options) {
      if (key == "ablation")
        apply_ablation(options, text);
      else if (key != "checkpoint_every")
        set_option_from_text(options, key, text);
    }
    for (int64_t budget : config.budgets) set_option(options, "max_gaussians", budget);
    for (int64_t steps : config.steps) set_option(options, "iterations", steps);
    validate(options);
  }
}

void check_exports(const std::vector<std::string>& exports) {
  std::vector<std::string> known;
  for (const TimeFormat& format : time_formats()) known.emplace_back(format.name);
  for (const SplatFormat& format : splat_formats()) known.emplace_back(format.name);
  for (const std::string& name : exports)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw InputError(fmt::format("--exports: unknown format '{}'; there are {}", name,
                                   fmt::join(known, ", ")));
}

void check_numbers(const BatchConfig& config) {
  for (int64_t budget : config.budgets)
    if (budget < 1)
      throw InputError(fmt::format("--budgets has {}; pass numbers of Gaussians above 0", budget));
  for (int64_t steps : config.steps)
    if (steps < 1) throw InputError(fmt::format("--steps has {}; pass 1 or more", steps));
  for (int64_t seed : config.seeds)
    if (seed < 0) throw InputError(fmt::format("--seeds has {}; pass 0 or more", seed));
  if (config.threads < 1)
    throw InputError(fmt::format("--threads is {}, expected 1 or more", config.threads));
  if (config.window_jobs < 1)
    throw InputError(fmt::format("--window-jobs is {}, expected 1 or more", config.window_jobs));
  if (config.gpus < 0)
    throw InputError(fmt::format("--gpus is {}, expected 0 or more", config.gpus));
  if (!config.budgets.empty() && config.options.contains("max_gaussians"))
    throw InputError("--budgets are numbers of Gaussians; pass them or --max-gaussians, not both");
  if (!config.steps.empty() && config.options.contains("iterations"))
    throw InputError("--steps are those of trainings; pass them or --iterations, not both");
  if (config.options.contains("seed")) throw InputError("--seed has no meaning here; use --seeds");
}

/// The path of the running program.
std::string this_program() {
  return std::filesystem::read_symlink("/proc/self/exe").string();
}

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

/// Names become folders and words of command lines: letters, digits and _ . + - stay, and others
/// become one _ where they stand together, as in safe_name of checks.py.
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

/// PATH and split of PATH:val; all of a word that names a folder is its path.
std::pair<std::string, std::string> path_and_split(const std::string& word) {
  const size_t colon = word.rfind(':');
  if (colon != std::string::npos && !fs::exists(word))
    for (const Split split : {Split::kTest, Split::kVal, Split::kTrain})
      if (word.substr(colon + 1) == name_of(split)) return {word.substr(0, colon), name_of(split)};
  return {word, ""};
}

/// The options of ingest without --test-every, where the capture has test views of its own.
std::vector<std::string> ingest_words_of(const Dataset& dataset, std::vector<std::string> words) {
  const auto option = std::find(words.begin(), words.end(), "--test-every");
  if (dataset.has_own_test_views && words.end() - option >= 2) words.erase(option, option + 2);
  return words;
}

}  // namespace

json batch_yaml(const BatchConfig& config) {
  refuse_repeats(config.presets, "--preset");
  refuse_repeats(config.budgets, "--budgets");
  refuse_repeats(config.steps, "--steps");
  refuse_repeats(config.seeds, "--seeds");
  refuse_repeats(config.exports, "--exports");
  check_numbers(config);
  check_training(config);
  check_exports(config.exports);
  std::map<std::string, std::string> options = config.options;
  const auto deterministic = options.extract("deterministic");
  json scenes = json::array(), presets = json::array();
  for (const Dataset& dataset : config.datasets) {
    scenes.push_back({{"name", dataset.name},
                      {"path", dataset.path.string()},
                      {"ingest", ingest_words_of(dataset, config.ingest)}});
    if (!dataset.split.empty()) scenes.back()["split"] = dataset.split;
  }
  for (const std::string& preset : config.presets)
    presets.push_back(options.empty()
                          ? json(preset)
                          : json{{"name", preset}, {"preset", preset}, {"options", options}});
  json yaml = {{"scenes", scenes},
               {"seeds", config.seeds},
               {"exports", config.exports},
               {"tessera", this_program()},
               {"threads", config.threads},
               {"gpus", config.gpus},
               {"windows", config.windows},
               {"window_jobs", config.window_jobs},
               {"budgets", config.budgets},
               {"steps", config.steps},
               {"deterministic", !deterministic.empty() && deterministic.mapped() == "true"}};
  if (config.table.empty()) {
    yaml["presets"] = presets;
  } else {
    yaml["table"] = config.table;
    yaml["options"] = options;
  }
  return yaml;
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
