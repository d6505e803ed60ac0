// What: the checks, and the object.
// Not: any file.
#include "tools/batch/batch_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options.h"
#include "static3d/formats/splat_file.h"
#include "tools/cli/named_once.h"
#include "tools/export/in_time.h"

namespace tessera {
namespace {

using nlohmann::json;

/// Presets and options as a training would take them. Errors: InputError.
void check_training(const BatchConfig& config) {
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
  for (int64_t seed : config.seeds)
    if (seed < 0) throw InputError(fmt::format("--seeds has {}; pass 0 or more", seed));
  if (config.threads < 1)
    throw InputError(fmt::format("--threads is {}, expected 1 or more", config.threads));
  if (config.gpus < 0)
    throw InputError(fmt::format("--gpus is {}, expected 0 or more", config.gpus));
  if (!config.budgets.empty() && config.options.contains("max_gaussians"))
    throw InputError("--budgets are numbers of Gaussians; pass them or --max-gaussians, not both");
  if (config.options.contains("seed")) throw InputError("--seed has no meaning here; use --seeds");
}

/// The path of the running program.
std::string this_program() {
  return std::filesystem::read_symlink("/proc/self/exe").string();
}

}  // namespace

namespace {

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
  refuse_repeats(config.seeds, "--seeds");
  refuse_repeats(config.exports, "--exports");
  check_numbers(config);
  check_training(config);
  check_exports(config.exports);
  std::map<std::string, std::string> options = config.options;
  const auto deterministic = options.extract("deterministic");
  json scenes = json::array(), presets = json::array();
  for (const Dataset& dataset : config.datasets)
    scenes.push_back({{"name", dataset.name},
                      {"path", dataset.path.string()},
                      {"ingest", ingest_words_of(dataset, config.ingest)}});
  for (const std::string& preset : config.presets)
    presets.push_back(options.empty()
                          ? json(preset)
                          : json{{"name", preset}, {"preset", preset}, {"options", options}});
  json yaml = {{"scenes", scenes},
               {"presets", presets},
               {"seeds", config.seeds},
               {"exports", config.exports},
               {"tessera", this_program()},
               {"threads", config.threads},
               {"gpus", config.gpus},
               {"budgets", config.budgets},
               {"deterministic", !deterministic.empty() && deterministic.mapped() == "true"}};
  return yaml;
}

}  // namespace tessera
