// Defines the training options and resolves their layers: defaults, preset, ablation, --config,
// command line.
#include "tools/cli/train_arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "ingest/files/json_file.h"
#include "ingest/prepared/scene_reader.h"
#include "kernels/base/errors.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options_json.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/option_reference.h"

namespace tessera {
namespace {

/// A switch is a flag with a twin, "--carve" and "--no-carve"; every other row takes a value.
void add_row(CLI::App& command, const TrainOption& row, TrainArguments& arguments) {
  const std::string key = row.key, name = dashed(key);
  if (row.is_switch())
    command
        .add_flag_function(
            fmt::format("--{0},!--no-{0}", name),
            [&arguments, key](int64_t count) {
              arguments.given[key] = count > 0 ? "true" : "false";
            },
            row.doc)
        ->group(row.group);
  else
    command
        .add_option_function<std::string>(
            "--" + name,
            [&arguments, key](const std::string& text) { arguments.given[key] = text; }, row.doc)
        ->group(row.group);
}

/// `file`: an object of option: value, or the config.json of a run, which has one as `options`.
void apply_config(TrainOptions& options, const std::string& file) {
  nlohmann::json config = read_json(file);
  if (config.is_object() && config.contains("options")) config = nlohmann::json(config["options"]);
  if (!config.is_object())
    throw InputError(fmt::format("{}: expected a JSON object of option: value", file));
  for (const auto& [key, value] : config.items()) try {
      set_option_from_json(options, key, value);
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}", file, error.what()));
    }
}

TrainOptions layered_options(const TrainArguments& arguments, const SceneFacts& facts) {
  TrainOptions options;
  apply_preset(options, arguments.preset, facts);
  if (!arguments.ablation.empty()) apply_ablation(options, arguments.ablation);
  if (!arguments.config.empty()) apply_config(options, arguments.config);
  for (const auto& [key, text] : arguments.given) set_option_from_text(options, key, text);
  validate(options);
  return options;
}

/// Makes the number of EvaluationPlan of `text`; returns what is wrong with it.
std::string evaluation_steps(std::string& text) {
  if (text == kNever)
    text = fmt::format("{}", kNeverEvaluate);
  else if (text.empty() || text.find_first_not_of("0123456789") != std::string::npos)
    return fmt::format("'{}' is no number of steps, nor {}", text, kNever);
  return "";
}

/// As an option of the command line has it.
std::string with_dashes(std::string key) {
  std::replace(key.begin(), key.end(), '_', '-');
  return "--" + key;
}

}  // namespace

void add_train_options(CLI::App& command, TrainArguments& arguments) {
  std::string names;
  for (const Preset& preset : presets())
    names += fmt::format("\n    {:<10} {}", preset.name, preset.doc);
  command.add_option("--preset", arguments.preset, "set of options:" + names)
      ->capture_default_str();
  command.add_option("--ablation", arguments.ablation,
                     "techniques removed or added after the preset: no-NAME, basis+NAME");
  command.add_option("--config", arguments.config,
                     "JSON file of options, or the config.json of a run, after the preset");
  add_backend_options(command, arguments.backend);
  command.add_option("--threads", arguments.threads, "CPU threads; 0: all")->capture_default_str();
  command
      .add_option("--evaluate-every", arguments.evaluate_every,
                  "steps between scores of test views; 0: at the end; never: as in `run`")
      ->transform(CLI::Validator(&evaluation_steps, ""));
  command
      .add_option("--checkpoint-every", arguments.checkpoint_every,
                  "steps between two checkpoints; 0: at the end; default: every minute")
      ->check(CLI::NonNegativeNumber);
  add_option_table(command, arguments);
}

void add_option_table(CLI::App& command, TrainArguments& arguments) {
  for (const TrainOption& row : train_option_table()) add_row(command, row, arguments);
  command.add_flag_callback(
      "--static", [&arguments] { arguments.given["motion"] = "none"; }, "same as --motion none");
}

std::vector<std::string> words_of(const TrainArguments& arguments) {
  std::vector<std::string> words{"--preset", arguments.preset};
  const auto add = [&](const std::string& option, const std::string& value) {
    words.insert(words.end(), {option, value});
  };
  if (!arguments.ablation.empty()) add("--ablation", arguments.ablation);
  if (!arguments.config.empty())
    add("--config", std::filesystem::absolute(arguments.config).string());
  for (const auto& [key, value] : arguments.given) add(with_dashes(key), value);
  if (arguments.evaluate_every != 0)
    add("--evaluate-every", arguments.evaluate_every == kNeverEvaluate
                                ? kNever
                                : fmt::format("{}", arguments.evaluate_every));
  if (arguments.checkpoint_every)
    add("--checkpoint-every", fmt::format("{}", *arguments.checkpoint_every));
  return words;
}

PlannedOptions resolve_options(const TrainArguments& arguments, SceneFacts facts) {
  const TrainOptions asked = layered_options(arguments, {});
  facts.still |= asked.motion == Motion::kNone;
  facts.camera_pixels =
      std::llround(asked.train_scale * asked.train_scale * double(facts.camera_pixels));
  facts.nodes = asked.motion == Motion::kNodes;
  PlannedOptions planned{layered_options(arguments, facts), std::nullopt};
  if (planned.options.motion != Motion::kAuto) return planned;
  facts.nodes = true;
  planned.with_nodes = layered_options(arguments, facts);
  planned.with_nodes->motion = Motion::kNodes;
  validate(*planned.with_nodes);
  return planned;
}

PlannedOptions resolve_options(const TrainArguments& arguments, const std::filesystem::path& scene,
                               const std::optional<Window>& window) {
  const bool is_still = layered_options(arguments, {}).motion == Motion::kNone;
  return resolve_options(arguments, facts_of(scene_without_pixels(scene, is_still, window)));
}

}  // namespace tessera
