// Reads config.json and the log of a run folder.
#include "tools/live/earlier_training.h"

#include <fmt/format.h>

#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "recon4d/options/train_options_json.h"
#include "tools/export/formats.h"
#include "tools/live/stopped_training.h"
#include "tools/session/static_model.h"
#include "tools/session/windows_folder.h"

namespace tessera {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {
constexpr const char* kWindow = "window";
constexpr const char* kWholeClip = "the whole clip";
constexpr const char* kStaticModel = "static model";
constexpr const char* kItsOwn = "trained with the rest";
}  // namespace

json asked_of_training(const TrainArguments& arguments, const PlannedOptions& planned,
                       const std::optional<Window>& window, const fs::path& static_model) {
  json options = to_json(planned.options);
  if (planned.with_nodes) options["with_nodes"] = to_json(*planned.with_nodes);
  return {{"preset", arguments.preset},
          {"ablation", arguments.ablation},
          {"options", std::move(options)},
          {kWindow, window ? text_of(*window) : kWholeClip},
          {kStaticModel, static_model.empty() ? kItsOwn : static_model_digest(static_model)},
          {kWindows, 1}};
}

void take_arguments(const TrainArguments& arguments, PlannedOptions planned,
                    const std::string& files, TrainRequest& request) {
  json asked = asked_of_training(arguments, planned, request.window, request.static_model);
  asked[kSceneFiles] = files;
  request.made_for = json_text(asked);
  request.options = std::move(planned.options);
  request.with_nodes = std::move(planned.with_nodes);
  request.preset = arguments.preset;
  request.ablation = arguments.ablation;
  request.backend = arguments.backend;
  request.evaluate_every = arguments.evaluate_every;
  request.checkpoint_every = arguments.checkpoint_every;
  request.shipped_bytes = shipped_bytes_of(request.run.string());
}

json recorded_result(const RunFolder& run) {
  json result = last_result(run);
  if (!result.is_object()) return result;
  result.erase("event");
  result["model"] = run.model().string();  // the run may have been moved
  return result;
}

namespace {

RunRecord record_of_windows(const WindowsFolder& folder) {
  WindowsPlan plan = folder.read();
  if (plan.request.is_object()) plan.request.emplace(kWindows, plan.windows.size());
  return {true, true, folder.missing(plan).empty(), plan.request};
}

}  // namespace

RunRecord record_of(const RunFolder& run, const fs::path& scene) {
  if (const WindowsFolder windows{run.root}; windows.exists()) return record_of_windows(windows);
  if (!run.exists()) return {};
  RunRecord record{fs::exists(run.checkpoint()), fs::exists(run.model()), false, {}};
  const json result = last_result(run);
  record.finished = record.has_model && result.is_object() && result.value("finished", false);
  const json config = json::parse(read_text_file(run.config()), nullptr, false);
  if (!config.is_object()) return record;
  record.request = json::parse(config.value("made_for", ""), nullptr, false);
  if (!record.request.is_object()) {
    record.request = nullptr;
    const json options = config.value("asked_options", json());
    if (options.is_object() && config.value("scene", "") == fs::absolute(scene).string())
      record.request = {{"preset", config.value("preset", "")}, {"options", options}};
  }
  if (record.request.is_object()) {  // by a version that knew no windows
    record.request.emplace(kWindow, kWholeClip);
    record.request.emplace(kStaticModel, kItsOwn);
    record.request.emplace(kWindows, 1);
  }
  // a resumed training may have been given more steps than it was begun with
  if (record.finished && record.request.is_object())
    record.request["options"]["iterations"] = result.at("total_iterations");
  return record;
}

}  // namespace tessera
