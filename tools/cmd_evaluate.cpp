// What: `tessera evaluate`: a model against the held-out frames of a scene.
// Not: the metrics (recon4d/evaluate.h).
#include <fmt/format.h>

#include <cmath>

#include "ingest/scene_reader.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/scene_scale.h"
#include "recon4d/train_options.h"
#include "tools/backend_choice.h"
#include "tools/camera_views.h"
#include "tools/command.h"
#include "tools/held_out_scores.h"
#include "tools/interrupt.h"
#include "tools/model_input.h"
#include "tools/output_folder.h"
#include "tools/picture_files.h"
#include "tools/run_folder.h"
#include "tools/terminal.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

struct EvaluateRequest {
  std::string model, scene, split, background, images, backend = "auto";
  std::vector<double> scales{1};  // of the size that was trained on
  int threads = 0;
  bool overwrite = false, json = false;
};

/// Where the pictures of a scale lie: in the folder itself where there is only one.
std::string picture_folder(const EvaluateRequest& request, double scale) {
  return request.scales.size() == 1 ? "" : fmt::format("x{}/", scale);
}

/// --scene, else what the run folder was trained on.
fs::path scene_path(const EvaluateRequest& request) {
  if (!request.scene.empty()) return request.scene;
  const fs::path model = request.model;
  const RunFolder run{fs::is_directory(model) ? model : model.parent_path()};
  const std::string scene = run.exists() ? run.read_config().value("scene", "") : "";
  if (scene.empty())
    throw InputError(
        fmt::format("{}: no run folder that names its scene; pass --scene FOLDER", request.model));
  if (!fs::exists(scene))
    throw InputError(
        fmt::format("{}: its scene {} is gone; pass --scene FOLDER", run.config().string(), scene));
  return scene;
}

/// With times on the model's clock.
Scene open_scene(const EvaluateRequest& request, const GaussianModel& model) {
  SceneOptions options;
  options.background = model.background, options.allow_static = true;
  Scene scene = load_scene(scene_path(request), options);
  for (const std::string& warning : scene.warnings) warn(warning);
  for (Frame& frame : scene.frames) {
    frame.time = model_time(model, scene.time_axis, frame.time);
    frame.camera = model_camera(model, scene.prepared_from_source, frame.camera);
  }
  return scene;
}

std::vector<Split> chosen_splits(const EvaluateRequest& request, const Scene& scene) {
  if (!request.split.empty()) return {parse_split(request.split)};
  const std::vector<Split> splits = held_out_splits(scene);
  if (splits.empty())
    throw InputError(fmt::format(
        "{}: no frames are held out; pass --split train to score what was trained on", scene.path));
  return splits;
}

std::vector<std::string> picture_names(const EvaluateRequest& request, const Scene& scene,
                                       const std::vector<Split>& splits) {
  std::vector<std::string> files;
  for (const double scale : request.scales)
    for (Split split : splits)
      for (int i : scene.split_indices(split))
        files.push_back(picture_folder(request, scale) + scene.frames[size_t(i)].name + ".png");
  return files;
}

/// At one scale.
nlohmann::json score_at(const EvaluateRequest& request, double scale, const ModelInput& input,
                        const Scene& scene, Backend& backend, std::optional<OutputFolder>& images) {
  ProgressBar bar("evaluate");
  return score_splits(
      backend, input.model, scene, chosen_splits(request, scene), input.bytes,
      [&](const Frame& frame, const Picture& picture, const ViewScore& view, int64_t done,
          int64_t total) {
        stop_if_interrupted();
        if (images)
          write_picture_png(images->path(picture_folder(request, scale) + frame.name + ".png"),
                            picture);
        bar.update(done, total, fmt::format("{} {:.2f} dB", split_name(frame.split), view.psnr));
      });
}

/// The scores at scale 1, or at the first where it is not asked for; those of each under `scales`.
nlohmann::json score(const EvaluateRequest& request, const ModelInput& input, const Scene& scene,
                     Backend& backend) {
  std::optional<OutputFolder> images;
  if (!request.images.empty())
    images.emplace(request.images, "evaluate",
                   picture_names(request, scene, chosen_splits(request, scene)), request.overwrite);
  nlohmann::json result = nlohmann::json::object(), by_scale = nlohmann::json::object();
  for (const double scale : request.scales) {
    const double truth = truth_scale(scale, input.model.train_scale);
    nlohmann::json scores =
        truth == 1 ? score_at(request, scale, input, scene, backend, images)
                   : score_at(request, scale, input, scaled_scene(scene, truth), backend, images);
    if (result.empty() || scale == 1) result = scores;
    by_scale[fmt::format("{}", scale)] = std::move(scores);
  }
  result["scales"] = std::move(by_scale);
  if (images) images->finish();
  return result;
}

/// A line for each split, headed by the scale where there are several.
std::string scores_lines(const EvaluateRequest& request, const nlohmann::json& scores) {
  if (request.scales.size() == 1) return scores_text(scores);
  std::string text;
  for (const double scale : request.scales)
    text += fmt::format("{}scale {}: {}", text.empty() ? "" : "\n", scale,
                        scores_text(scores["scales"][fmt::format("{}", scale)]));
  return text;
}

int evaluate_command(const EvaluateRequest& request) {
  for (const double scale : request.scales)
    if (!(scale > 0 && std::isfinite(scale)))
      throw InputError(fmt::format("--scales has {}; expected numbers above 0, as 0.5,1,2", scale));
  set_thread_count(request.threads);
  ModelInput input = load_model_input(request.model);
  for (const std::string& warning : input.warnings) warn(warning);
  if (!request.background.empty()) input.model.background = parse_background(request.background);
  const Scene scene = open_scene(request, input.model);
  const std::unique_ptr<Backend> backend = make_backend(request.backend);
  nlohmann::json scores = score(request, input, scene, *backend);
  scores["model"] = input.file.string(), scores["scene"] = scene.path;
  scores["backend"] = backend->name();
  print_result(
      request.json, scores,
      fmt::format("{}\n{} Gaussians ({} static, {} dynamic), {} bytes",
                  scores_lines(request, scores), input.model.count(),
                  input.model.static_set.count(), input.model.dynamic_set.count(), input.bytes));
  return kExitDone;
}

}  // namespace

void add_evaluate_command(CLI::App& app, Work& work) {
  CLI::App* command = app.add_subcommand("evaluate", "score a model on held-out frames");
  command->option_defaults()->always_capture_default();
  const auto request = std::make_shared<EvaluateRequest>();
  command->add_option("model", request->model, "run folder, checkpoint, 3DGS or Tessera .ply")
      ->required();
  command->add_option("--scene", request->scene,
                      "prepared scene or D-NeRF folder; a run folder knows its own");
  command->add_option("--split", request->split, "test, val or train; default: all held-out ones");
  command
      ->add_option("--scales", request->scales,
                   "sizes to score at, by that of training: 0.5,1,2; larger ones need a model that "
                   "was trained with --train-scale")
      ->delimiter(',');
  command->add_option("--background", request->background,
                      "black, white or r,g,b; default: the model's");
  command->add_option("--save-images", request->images, "folder for the rendered pictures");
  command->add_flag("--overwrite", request->overwrite, "save among files that are not ours");
  command->add_option("--backend", request->backend,
                      "auto (a CUDA device where there is one), cpu or cuda");
  command->add_option("--threads", request->threads, "CPU threads; 0: all");
  command->add_flag("--json", request->json, "print one JSON object");
  command->callback([&work, request] { work = [request] { return evaluate_command(*request); }; });
}

}  // namespace tessera
