// What: `tessera train`: options from preset, ablation, --config and command line, in that order.
// Not: the training (train_session.cpp).
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "ingest/files/json_file.h"
#include "ingest/layouts/scene_reader.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/model/checkpoint.h"
#include "recon4d/options/ablations.h"
#include "recon4d/options/scene_facts.h"
#include "recon4d/options/train_options_json.h"
#include "tools/cli/command.h"
#include "tools/cli/terminal.h"
#include "tools/cli/train_arguments.h"
#include "tools/session/backend_choice.h"
#include "tools/session/held_out_scores.h"
#include "tools/session/interrupt.h"
#include "tools/session/output_place.h"
#include "tools/session/time_limit.h"

namespace tessera {
namespace {

std::string dashed(std::string key) {
  for (char& c : key)
    if (c == '_') c = '-';
  return key;
}

/// "" without validation.
std::string validation_text(const nlohmann::json& checks) {
  if (checks.is_null()) return "";
  return fmt::format(
      "the model is that of step {} ({}), best of {} checks: PSNR {:.2f} dB on {} frames set "
      "aside{}",
      checks["best_iteration"].get<int64_t>(), clock_time(checks["best_seconds"]),
      checks["checks"].get<int64_t>(), checks["best_psnr"].get<double>(),
      checks["frames"].get<int64_t>(),
      checks["stopped"].get<bool>()
          ? fmt::format("; stopped at step {}", checks["stop_iteration"].get<int64_t>())
          : "");
}

}  // namespace

void add_train_options(CLI::App& command, TrainArguments& arguments) {
  std::string names;
  for (const Preset& preset : presets())
    names += fmt::format("\n    {:<10} {}", preset.name, preset.doc);
  command.add_option("--preset", arguments.preset, "set of options:" + names)
      ->capture_default_str();
  command.add_option("--ablation", arguments.ablation,
                     "techniques taken out or added, over the preset's: full, basis, no-..., "
                     "basis+...; a wrong name lists them");
  command.add_option("--config", arguments.config,
                     "JSON file of options, or the config.json of a run, over the preset's");
  add_backend_options(command, arguments.backend);
  command.add_option("--threads", arguments.threads, "CPU threads; 0: all")->capture_default_str();
  command.add_option("--evaluate-every", arguments.evaluate_every,
                     "steps between two evaluations of the held-out splits; 0: at the end only");
  command
      .add_option("--checkpoint-every", arguments.checkpoint_every,
                  "steps between two checkpoints; 0: at the end only")
      ->capture_default_str();
  add_option_rows(command, arguments);
}

void add_option_rows(CLI::App& command, TrainArguments& arguments) {
  for (const OptionRow& row : train_option_rows()) {
    const std::string key = row.key;
    // of `run` and `batch`, where the word is shared with ingest's (commands/run.cpp)
    if (command.get_option_no_throw("--" + dashed(key)) != nullptr) continue;
    command
        .add_option_function<std::string>(
            "--" + dashed(key),
            [&arguments, key](const std::string& text) { arguments.given[key] = text; }, row.doc)
        ->group("Training");
  }
  command.add_flag_callback(
      "--static", [&arguments] { arguments.given["static_only"] = "true"; },
      "one timestep: same as --static-only true");
}

namespace {

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

}  // namespace

TrainOptions resolve_options(const TrainArguments& arguments, SceneFacts facts) {
  const TrainOptions asked = layered_options(arguments, {});
  facts.still |= asked.static_only;
  facts.camera_pixels =
      std::llround(asked.train_scale * asked.train_scale * double(facts.camera_pixels));
  return layered_options(arguments, facts);
}

TrainOptions resolve_options(const TrainArguments& arguments, const std::filesystem::path& scene) {
  SceneOptions options;
  options.allow_static = layered_options(arguments, {}).static_only;
  options.load_pixels = false;
  return resolve_options(arguments, facts_of(load_scene(scene, options)));
}

std::string training_text(const nlohmann::json& result) {
  const std::string text =
      fmt::format("{} steps in {}, {} static + {} dynamic Gaussians, model {}",
                  result["iterations"].get<int64_t>(), clock_time(result["seconds"]),
                  result["num_static"].get<int64_t>(), result["num_dynamic"].get<int64_t>(),
                  result["model"].get<std::string>());
  const std::string checks = validation_text(result["validation"]);
  const std::string scores = scores_text(result["scores"]);
  return text + (checks.empty() ? "" : "\n" + checks) + (scores.empty() ? "" : "\n" + scores);
}

namespace {

/// The exit code.
int train_and_report(const TrainRequest& request, bool as_json) {
  try {
    const nlohmann::json result = train_session(request);
    print_result(as_json, result, training_text(result));
    if (interrupted()) return stop_code();
    return result["left"].get<bool>() ? kExitNotFinished : kExitDone;
  } catch (const CheckpointRefused& error) {
    say(fmt::format("tessera: {}", error.what()));
    return kExitCheckpointRefused;
  }
}

}  // namespace

void add_train_command(CLI::App& app, Work& work) {
  struct Parsed {
    TrainRequest request;
    TrainArguments arguments;
    bool json = false;
    int64_t stop_after = 0;
    std::string time_limit;
  };
  const auto parsed = std::make_shared<Parsed>();
  CLI::App& command = *app.add_subcommand("train", "prepared scene or D-NeRF folder -> run folder");
  command.add_option("scene", parsed->request.scene, "prepared scene or D-NeRF folder")->required();
  command.add_option("-o,--out", parsed->request.run, "run folder")->required();
  command.add_flag("--resume", parsed->request.resume,
                   "go on from the run folder's checkpoint, with its options");
  command.add_flag("--overwrite", parsed->request.overwrite, "replace the run that is there");
  command.add_option("--stop-after", parsed->stop_after, "stop after so many steps of this call");
  command.add_option("--time-limit", parsed->time_limit,
                     "leave with a checkpoint and exit code 75 before so long has passed: seconds, "
                     "2h, 90m, 1h30m; --resume goes on. SIGTERM and SIGUSR1 do the same at once");
  command.add_flag("--json", parsed->json, "print one JSON object");
  add_train_options(command, parsed->arguments);
  command.callback([parsed, &work] {
    work = [parsed] {
      TrainRequest& request = parsed->request;
      request.stopwatch = running_stopwatch();
      if (!parsed->time_limit.empty()) request.time_limit = parse_duration(parsed->time_limit);
      const TrainArguments& arguments = parsed->arguments;
      set_thread_count(arguments.threads);
      check_output_apart(request.run, request.scene);
      request.options = resolve_options(arguments, request.scene);
      request.preset = arguments.preset, request.ablation = arguments.ablation;
      request.backend = arguments.backend;
      request.evaluate_every = arguments.evaluate_every;
      request.checkpoint_every = arguments.checkpoint_every;
      if (parsed->stop_after > 0) request.stop_after = parsed->stop_after;
      if (request.resume &&
          (!arguments.given.empty() || !arguments.config.empty() || !arguments.ablation.empty()))
        throw InputError(
            "--resume goes on with the options of the checkpoint; drop the training options or "
            "start a new run folder");
      return train_and_report(request, parsed->json);
    };
  });
}

}  // namespace tessera
