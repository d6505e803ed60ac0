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
#include "tools/clip/clip.h"
#include "tools/clip/clip_scores.h"
#include "tools/commands/object_boxes.h"
#include "tools/export/formats.h"
#include "tools/export/image_files.h"
#include "tools/lpips/lpips.h"
#include "tools/session/held_out_scores.h"
#include "tools/session/locks.h"
#include "tools/session/model_scene.h"
#include "tools/session/output_folder.h"

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
  bool fit_clocks = false;
};

/// Where the images of a scale lie: in the folder itself where there is only one.
std::string image_folder(const EvaluateRequest& request, double scale) {
  return request.scales.size() == 1 ? "" : fmt::format("x{}/", scale);
}

/// --scene, else what the model was trained on.
fs::path scene_path(const EvaluateRequest& request, const fs::path& model) {
  return request.scene.empty() ? require_scene_of(model) : fs::path(request.scene);
}

/// Those that are asked for, of a scene without pixels.
std::vector<Split> chosen_splits(const EvaluateRequest& request, const Scene& scene) {
  if (!request.split.empty() && request.split != kAutoSplit) return {parse_split(request.split)};
  const std::vector<Split> splits = held_out_splits(scene);
  if (!splits.empty()) return splits;
  if (request.split == kAutoSplit) return {Split::kTrain};
  throw InputError(fmt::format(
      "{}: no frames are held out; pass --split train to score what was trained on", scene.path));
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

EvaluateOptions options_of(const EvaluateRequest& request, Lpips* lpips,
                           const std::optional<ObjectBoxes>& boxes) {
  EvaluateOptions options;
  options.fit_clocks = request.fit_clocks;
  if (lpips != nullptr)
    options.lpips = [lpips](const Image8& drawn, const Image8& truth) {
      return lpips->distance(drawn, truth);
    };
  if (!request.moving_masks.empty())
    options.moving_mask = [&](const Frame& frame) {
      return moving_mask(request.moving_masks, frame);
    };
  if (boxes) options.object_boxes = [&](const Frame& frame) { return boxes->of(frame); };
  return options;
}

/// The scores at scale 1, or at the first where 1 is not requested; those of each under `scales`.
json score(const EvaluateRequest& request, const Clip& clip, const Scene& scene,
           const std::vector<Split>& splits, Lpips* lpips, Backend& backend) {
  if (request.fit_clocks && clip.count() > 1)
    throw InputError("--fit-clocks is of one model; name a window of the clip");
  std::optional<ObjectBoxes> boxes;
  if (!request.boxes.empty()) boxes.emplace(request.boxes).check_fits(scene, splits);
  std::optional<OutputFolder> images;
  if (!request.images.empty())
    images.emplace(request.images, "evaluate", image_names(request, scene, splits),
                   request.overwrite);
  const EvaluateOptions options = options_of(request, lpips, boxes);
  json result = json::object(), by_scale = json::object();
  for (const double scale : request.scales) {
    json scores = score_clip(
        backend, clip, scene.path, splits, options, scale,
        [&](const Frame& frame, const RenderedImage& image, const ViewScore&, int64_t, int64_t) {
          if (images)
            write_image_png(images->path(image_folder(request, scale) + frame.name + ".png"),
                            image);
        });
    if (result.empty() || scale == 1) result = scores;
    by_scale[fmt::format("{}", scale)] = std::move(scores);
  }
  result["scales"] = std::move(by_scale);
  if (images) images->finish();
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

/// Of the views of the window with the most Gaussians, which is the slowest.
json frame_rate_json(Backend& backend, const Clip& clip, const Scene& scene,
                     const std::vector<Split>& splits) {
  GaussianModel model = clip.windows.load(0);
  int slowest = 0;
  for (int i = 1; i < int(clip.count()); ++i)
    if (GaussianModel other = clip.windows.load(i); other.count() > model.count()) {
      model = std::move(other);
      slowest = i;
    }
  std::vector<View> views;
  for (Split split : splits)
    for (int i : scene.split_indices(split))
      if (const Frame& frame = scene.frames[size_t(i)];
          window_at(clip.windows.windows, frame.time) == slowest)
        views.push_back(
            {frame.camera, window_time(clip.windows.windows[size_t(slowest)], frame.time)});
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

std::string frame_rate_text(const json& rate) {
  return fmt::format(
      "\n{:.1f} frames/s of {} x {} pixels, {} frames, measured by the clock of the {}",
      rate["fps"].get<double>(), rate["width"].get<int>(), rate["height"].get<int>(),
      rate["frames"].get<int64_t>(), rate["clock"] == "host" ? "host" : "device");
}

std::string counts_text(const Clip& clip, const json& scores) {
  const auto count = [&](const char* key) { return scores[key].get<int64_t>(); };
  if (clip.count() == 1)
    return fmt::format("{} Gaussians ({} static, {} dynamic), {}", count("num_gaussians"),
                       count("num_static"), count("num_dynamic"),
                       clip.bytes ? fmt::format("model file {}", size_text(*clip.bytes))
                                  : "read from a checkpoint");
  const json& borders = scores["borders"];
  return fmt::format(
      "  temporal error across borders {}/255, inside {}/255; of moving pixels {} and {}\n{} "
      "windows over {} static Gaussians, {} dynamic ones in all, at most {} at a time",
      number_text(borders["border"], 2), number_text(borders["inside"], 2),
      number_text(borders["border_moving"], 2), number_text(borders["inside_moving"], 2),
      clip.count(), count("num_static"), count("num_dynamic"), count("peak_gaussians"));
}

/// Of one model or clip, with the lines for a person under `text`.
json evaluate_model(const EvaluateRequest& request, const std::string& path, Lpips* lpips,
                    Backend& backend, std::string& text) {
  Clip clip = load_clip(path);
  const fs::path folder = scene_path(request, path);
  if (request.scene.empty())
    if (const std::string changed = changed_scene(path, folder.string()); !changed.empty())
      warn(changed);
  for (const std::string& warning : clip.warnings) warn(warning);
  clip.edit([&](GaussianModel& model) { replace_background(request.background, model); });
  if (!request.images.empty()) check_output_of_model(request.images, path, folder);
  const SceneLock in_use(folder, SceneLock::Use::kRead);
  const Scene scene = scene_for(*clip.head, path, folder, {.load_pixels = false});
  for (const std::string& warning : scene.warnings) warn(warning);
  const std::vector<Split> splits = chosen_splits(request, scene);
  json scores = score(request, clip, scene, splits, lpips, backend);
  if (!scores.contains("psnr"))
    throw InputError(fmt::format("{}: has no frames of the split {}", scene.path, request.split));
  scores["model"] = clip.file.string();
  scores["scene"] = scene.path;
  scores["backend"] = backend.name();
  if (request.as_json && clip.count() == 1)
    scores["shipped_bytes"] = shipped_bytes(path, *clip.head);
  text = fmt::format("{}\n{}", scores_lines(request, scores), counts_text(clip, scores));
  if (!request.fps) return scores;
  scores["frame_rate"] = frame_rate_json(backend, clip, scene, splits);
  text += frame_rate_text(scores["frame_rate"]);
  return scores;
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
    if (several) paths.insert(fs::weakly_canonical(scene_path(request, model)).string());
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
    runs.push_back(evaluate_model(request, model, network, *backend, lines));
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
  command->add_flag("--fit-clocks", request->fit_clocks,
                    "draw and score the views of a camera at the offset of its clock, up to a "
                    "frame, that fits its images best");
  command->add_flag("--fps", request->fps,
                    "time the renderer: 300 warm frames, or as many as fit in 20 s");
  command->add_flag(
      "--json", request->as_json,
      "print one JSON object, with the bits of each part of the model and of the "
      "Tessera 4D file, which is encoded for it: three seconds of a core for 100,000 Gaussians");
  command->callback([&work, request] { work = [request] { return evaluate_command(*request); }; });
}

}  // namespace tessera
