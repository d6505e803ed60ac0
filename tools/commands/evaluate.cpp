// `tessera evaluate` scores a model, or several runs, on the held-out frames of a scene.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/files/folders.h"
#include "ingest/files/png.h"
#include "ingest/images/alpha_and_mask.h"
#include "ingest/prepared/scene_reader.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/options/train_options.h"
#include "recon4d/training/scene_scale.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/command.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/output_place.h"
#include "tools/cli/terminal.h"
#include "tools/cli/training_terminal.h"
#include "tools/commands/object_boxes.h"
#include "tools/export/formats.h"
#include "tools/export/image_files.h"
#include "tools/lpips/lpips.h"
#include "tools/session/held_out_scores.h"
#include "tools/session/locks.h"
#include "tools/session/model_input.h"
#include "tools/session/output_folder.h"
#include "tools/session/run_folder.h"
#include "tools/windows/windows_scores.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

using nlohmann::json;

constexpr const char* kAutoSplit = "auto";

struct EvaluateRequest {
  std::vector<std::string> models;
  std::string scene, split, background, images, lpips, moving_masks, boxes, backend = "auto";
  std::vector<double> scales{1};  // of the size that was trained on
  int threads = 0;
  bool overwrite = false, lpips_resize = false, fps = false, as_json = false;
};

/// Where the images of a scale lie: in the folder itself where there is only one.
std::string image_folder(const EvaluateRequest& request, double scale) {
  return request.scales.size() == 1 ? "" : fmt::format("x{}/", scale);
}

/// --scene, else what the run was trained on.
fs::path scene_path(const EvaluateRequest& request, const fs::path& model) {
  if (!request.scene.empty()) return request.scene;
  if (const std::string scene = scene_of_model(model); !scene.empty()) return scene;
  const RunFolder run{fs::is_directory(model) ? run_folder_of(model) : model.parent_path()};
  if (run.scene().empty())
    throw InputError(
        fmt::format("{}: no run folder that names its scene; pass --scene FOLDER", model.string()));
  throw InputError(fmt::format("{}: its scene {} is gone; pass --scene FOLDER",
                               run.config().string(), run.scene()));
}

std::vector<Split> requested_splits(const EvaluateRequest& request) {
  return request.split.empty() ? kHeldOutSplits : std::vector{parse_split(request.split)};
}

std::vector<Split> chosen_splits(const EvaluateRequest& request, const Scene& scene) {
  if (!request.split.empty()) return requested_splits(request);
  const std::vector<Split> splits = held_out_splits(scene);
  if (splits.empty())
    throw InputError(fmt::format(
        "{}: no frames are held out; pass --split train to score what was trained on", scene.path));
  return splits;
}

std::vector<std::string> image_names(const EvaluateRequest& request, const Scene& scene,
                                     const std::vector<Split>& splits) {
  std::vector<std::string> files;
  for (const double scale : request.scales)
    for (Split split : splits)
      for (int i : scene.split_indices(split))
        files.push_back(image_folder(request, scale) + scene.frames[size_t(i)].name + ".png");
  return files;
}

/// What all scales of one model's evaluation share.
struct Scoring {
  const EvaluateRequest& request;
  const ModelInput& input;
  const std::vector<Split>& splits;
  Lpips* lpips;
  Backend& backend;
  std::optional<ObjectBoxes> boxes;
  std::optional<OutputFolder> images;
};

/// DIR/<name of the frame>.png.
Image8 moving_mask(const fs::path& folder, const Frame& frame) {
  const fs::path file = folder / (frame.name + ".png");
  Image8 mask = read_png(file);
  if (mask.channels != 1)
    throw InputError(fmt::format("{}: has {} channels; a mask of what moves is a grey image",
                                 file.string(), mask.channels));
  check_mask_size(mask, frame.image.width, frame.image.height, file);
  return mask;
}

json score_at(Scoring& scoring, double scale, const Scene& scene) {
  EvaluateOptions options;
  if (Lpips* const lpips = scoring.lpips)
    options.lpips = [lpips](const Image8& drawn, const Image8& truth) {
      return lpips->distance(drawn, truth);
    };
  if (!scoring.request.moving_masks.empty())
    options.moving_mask = [&](const Frame& frame) {
      return moving_mask(scoring.request.moving_masks, frame);
    };
  if (scoring.boxes)
    options.object_boxes = [&](const Frame& frame) { return scoring.boxes->of(frame); };
  std::optional<int64_t> bytes;
  if (!scoring.input.with_optimizer) bytes = scoring.input.bytes;
  ProgressBar bar("evaluate");
  return score_splits(
      scoring.backend, scoring.input.model, scene, scoring.splits, bytes,
      [&](const Frame& frame, const RenderedImage& image, const ViewScore& view, int64_t done,
          int64_t total) {
        stop_if_interrupted();
        if (scoring.images)
          write_image_png(
              scoring.images->path(image_folder(scoring.request, scale) + frame.name + ".png"),
              image);
        bar.update(done, total, fmt::format("{} {:.2f} dB", name_of(frame.split), view.psnr));
      },
      options);
}

/// The scores at scale 1, or at the first where 1 is not requested; those of each under `scales`.
json score(const EvaluateRequest& request, const ModelInput& input, const Scene& scene,
           const std::vector<Split>& splits, Lpips* lpips, Backend& backend) {
  Scoring scoring{request, input, splits, lpips, backend, {}, {}};
  if (!request.boxes.empty()) {
    scoring.boxes.emplace(request.boxes);
    scoring.boxes->check_fits(scene, splits);
  }
  if (!request.images.empty())
    scoring.images.emplace(request.images, "evaluate", image_names(request, scene, splits),
                           request.overwrite);
  json result = json::object(), by_scale = json::object();
  for (const double scale : request.scales) {
    const double truth = truth_scale(scale, input.model.train_scale);
    json scores = truth == 1 ? score_at(scoring, scale, scene)
                             : score_at(scoring, scale, scaled_scene(scene, truth));
    if (result.empty() || scale == 1) result = scores;
    by_scale[fmt::format("{}", scale)] = std::move(scores);
  }
  result["scales"] = std::move(by_scale);
  if (scoring.images) scoring.images->finish();
  return result;
}

/// A line for each split, headed by the scale where there are several.
std::string scores_lines(const EvaluateRequest& request, const json& scores) {
  if (request.scales.size() == 1) return scores_text(scores, score_detail());
  std::string text;
  for (const double scale : request.scales)
    text += fmt::format("{}scale {}, {}", text.empty() ? "" : "\n", scale,
                        scores_text(scores["scales"][fmt::format("{}", scale)], score_detail()));
  return text;
}

json frame_rate_json(Backend& backend, const GaussianModel& model, const Scene& scene,
                     const std::vector<Split>& splits) {
  std::vector<View> views;
  for (Split split : splits)
    for (int i : scene.split_indices(split))
      views.push_back({scene.frames[size_t(i)].camera, scene.frames[size_t(i)].time});
  if (views.empty()) throw InputError(fmt::format("{}: no view to time", scene.path));
  const RenderRate rate = measure_render_rate(backend, model, views);
  const bool on_host = &backend.memory() == &host_memory();
  return {{"fps", rate.fps()},
          {"ms_per_frame", 1e3 * rate.seconds / double(rate.frames)},
          {"wall_ms_per_frame", 1e3 * rate.wall_seconds / double(rate.frames)},
          {"frames", rate.frames},
          {"clock", on_host ? "host" : "device events"},
          {"width", rate.width},
          {"height", rate.height},
          {"num_gaussians", rate.num_gaussians}};
}

/// Of one model, with the lines for a person under `text`.
json evaluate_model(const EvaluateRequest& request, const std::string& path, Lpips* lpips,
                    Backend& backend, std::string& text) {
  ModelInput input = load_model_input(path);
  for (const std::string& warning : input.warnings) warn(warning);
  replace_background(request.background, input.model);
  const fs::path folder = scene_path(request, path);
  if (!request.images.empty()) check_output_of_model(request.images, path, folder);
  const SceneLock in_use(folder, SceneLock::Use::kRead);
  const Scene scene =
      scene_for(input.model, path, folder, {.pixels_of = requested_splits(request)});
  for (const std::string& warning : scene.warnings) warn(warning);
  const std::vector<Split> splits = chosen_splits(request, scene);
  json scores = score(request, input, scene, splits, lpips, backend);
  scores["model"] = input.file.string();
  scores["scene"] = scene.path;
  scores["backend"] = backend.name();
  if (request.as_json) scores["shipped_bytes"] = shipped_bytes(path, input.model);
  text = fmt::format("{}\n{} Gaussians ({} static, {} dynamic), {}", scores_lines(request, scores),
                     input.model.count(), input.model.static_set.count(),
                     input.model.dynamic_set.count(),
                     input.with_optimizer ? "read from a checkpoint"
                                          : fmt::format("model file {}", size_text(input.bytes)));
  if (!request.fps) return scores;
  const json rate = frame_rate_json(backend, input.model, scene, splits);
  scores["frame_rate"] = rate;
  text +=
      fmt::format("\n{:.1f} frames/s of {} x {} pixels, {} frames, measured by the clock of the {}",
                  rate["fps"].get<double>(), rate["width"].get<int>(), rate["height"].get<int>(),
                  rate["frames"].get<int64_t>(), rate["clock"] == "host" ? "host" : "device");
  return scores;
}

/// --scene, else that of the windows or of the run in which the file lies.
fs::path scene_of_clip(const EvaluateRequest& request, const WindowsFolder& folder,
                       const std::string& path) {
  if (request.scene.empty() && folder.exists()) return scene_of_windows(folder, folder.read());
  return scene_path(request, path);
}

/// Of a clip that was trained window by window, from its folder or its Tessera 4D file.
json evaluate_clip(const EvaluateRequest& request, const std::string& path, const ClipModels& clip,
                   Lpips* lpips, Backend& backend, std::string& text) {
  const WindowsFolder folder = windows_folder_of(path);
  for (const auto& [given, name] : {std::pair{!request.images.empty(), "--save-images"},
                                    {!request.boxes.empty(), "--boxes"},
                                    {!request.moving_masks.empty(), "--moving-masks"},
                                    {!request.background.empty(), "--background"},
                                    {request.scales != std::vector<double>{1}, "--scales"},
                                    {request.fps, "--fps"}})
    if (given)
      throw InputError(fmt::format(
          "{}: is of windows, and {} of one model; evaluate the run of a window, e.g. {}", path,
          name, (folder.exists() ? folder.window_run(0) : "OUT/run/windows/0000").string()));
  EvaluateOptions options;
  if (lpips != nullptr)
    options.lpips = [lpips](const Image8& drawn, const Image8& truth) {
      return lpips->distance(drawn, truth);
    };
  const fs::path scene = scene_of_clip(request, folder, path);
  const SceneLock in_use(scene, SceneLock::Use::kRead);
  json scores = score_windows(backend, clip.windows, scene, requested_splits(request), options,
                              folder.exists() ? folder.static_scene() : fs::path());
  if (scores.empty())
    throw InputError(
        fmt::format("{}: no frames are held out; pass --split train to score what was "
                    "trained on",
                    path));
  scores["model"] = folder.exists() ? folder.root.string() : path;
  scores["scene"] = scene.string();
  if (clip.bytes > 0) scores["bytes"] = clip.bytes;
  scores["backend"] = backend.name();
  const json& borders = scores["borders"];
  text = fmt::format(
      "{}\n  temporal error across borders {}/255, inside {}/255; of moving pixels {} and {}\n{} "
      "windows over {} static Gaussians, {} dynamic ones in all, at most {} at a time",
      scores_text(scores, score_detail()), number_text(borders["border"], 2),
      number_text(borders["inside"], 2), number_text(borders["border_moving"], 2),
      number_text(borders["inside_moving"], 2), scores["windows"].get<int64_t>(),
      scores["num_static"].get<int64_t>(), scores["num_dynamic"].get<int64_t>(),
      scores["peak_gaussians"].get<int64_t>());
  return scores;
}

/// With the splits that `auto` means for that model.
EvaluateRequest with_splits_of(EvaluateRequest request, const std::string& path) {
  if (request.split != kAutoSplit) return request;
  const fs::path scene = scene_of_clip(request, windows_folder_of(path), path);
  const bool all_trained = held_out_splits(scene_without_pixels(scene, true)).empty();
  request.split = all_trained ? name_of(Split::kTrain) : "";
  return request;
}

void warn_of_changed_scene(const fs::path& model) {
  const WindowsFolder windows = windows_folder_of(model);
  const std::string changed =
      windows.exists()
          ? changed_scene(windows.window_run(0), scene_of_windows(windows, windows.read()).string())
          : changed_scene(model, scene_of_model(model));
  if (!changed.empty()) warn(changed);
}

/// Checks what can be checked before a model is read.
void check_request(const EvaluateRequest& request) {
  for (const double scale : request.scales)
    if (!(scale > 0 && std::isfinite(scale)))
      throw InputError(fmt::format("--scales has {}; expected numbers above 0, as 0.5,1,2", scale));
  if (request.models.size() > 1 && !request.images.empty())
    throw InputError("--save-images takes one model; evaluate the runs one by one");
  if (!request.split.empty() && request.split != kAutoSplit) parse_split(request.split);
  if (!request.background.empty()) parse_background(request.background);
  if (!request.moving_masks.empty()) require_folder(request.moving_masks);
}

int evaluate_command(const EvaluateRequest& request) {
  check_request(request);
  set_thread_count(request.threads);
  const bool several = request.models.size() > 1;
  std::set<std::string> paths;
  for (const std::string& model : request.models)
    if (several && !windows_folder_of(model).exists())
      paths.insert(fs::weakly_canonical(scene_path(request, model)).string());
  if (paths.size() > 1)
    throw InputError(fmt::format(
        "the runs are of different scenes: {}; evaluate each scene's runs together, or pass "
        "--scene FOLDER",
        fmt::join(paths, ", ")));
  std::optional<Lpips> lpips;
  if (!request.lpips.empty()) lpips.emplace(request.lpips, request.lpips_resize);
  const std::unique_ptr<Backend> backend = make_backend(request.backend);
  std::vector<json> runs;
  std::string text;
  for (const std::string& model : request.models) {
    std::string lines;
    Lpips* const network = lpips ? &*lpips : nullptr;
    const std::optional<ClipModels> clip = clip_of(model);
    if (request.scene.empty()) warn_of_changed_scene(model);
    const EvaluateRequest asked = with_splits_of(request, model);
    runs.push_back(clip ? evaluate_clip(asked, model, *clip, network, *backend, lines)
                        : evaluate_model(asked, model, network, *backend, lines));
    text += several ? fmt::format("{}\n{}\n", model, lines) : lines;
  }
  if (!several) {
    print_result(request.as_json, runs.front(), text);
    return kExitDone;
  }
  json statistics = over_runs(runs);
  text += over_runs_text(statistics);
  statistics["runs"] = runs;
  print_result(request.as_json, statistics, text);
  return kExitDone;
}

}  // namespace

void add_evaluate_command(CLI::App& app, Work& work) {
  CLI::App* command = app.add_subcommand("evaluate", "score models on test views");
  command->option_defaults()->always_capture_default();
  const auto request = std::make_shared<EvaluateRequest>();
  command
      ->add_option("model", request->models,
                   "output of `tessera run`, run folder, checkpoint, 3DGS or Tessera .ply; several "
                   "runs of one scene, e.g. with several seeds: mean and sigma, too")
      ->required();
  command->add_option(
      "--scene", request->scene,
      "prepared scene or D-NeRF folder; default: the one that the run was trained on");
  command->add_option("--split", request->split,
                      "test, val or train; default: all held-out ones; auto: these, or training "
                      "views where nothing is held out");
  command
      ->add_option("--scales", request->scales,
                   "sizes to score at, by that of training: 0.5,1,2; larger ones need a model that "
                   "was trained with --train-scale")
      ->delimiter(',');
  command->add_option("--background", request->background,
                      "black, white or r,g,b; default: the model's");
  command->add_option(
      "--moving-masks", request->moving_masks,
      "folder of grey masks named as the frames, 0: never moves there, 128: at some "
      "timestep, 255: now: how much of the dynamic Gaussians' light lies there; "
      "`tessera synth patch` makes them in ground_truth/moving");
  command->add_option("--boxes", request->boxes,
                      "ground_truth.json of a rig of `tessera synth`: scores of the pixels in the "
                      "box of each object that moves, by timestep");
  command->add_option("--save-images", request->images, "folder for the rendered images");
  command->add_flag("--overwrite", request->overwrite, "save among files that are not ours");
  add_backend_options(*command, request->backend);
  command->add_option("--threads", request->threads, "CPU threads; 0: all");
  command->add_option("--lpips", request->lpips,
                      "ONNX file: LPIPS by its network: two inputs [1, 3, height, width], RGB in "
                      "[-1, 1], one output");
  command->add_flag("--lpips-resize", request->lpips_resize,
                    "bring images to the sides that the ONNX file fixes");
  command->add_flag("--fps", request->fps,
                    "time the renderer: 300 warm frames, or as many as fit in 20 s");
  command->add_flag(
      "--json", request->as_json,
      "print one JSON object, with the bits of each part of the model and of the "
      "Tessera 4D file, which is encoded for it: three seconds of a core for 100,000 Gaussians");
  command->callback([&work, request] { work = [request] { return evaluate_command(*request); }; });
}

}  // namespace tessera
