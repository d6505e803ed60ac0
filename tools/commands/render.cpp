// `tessera render` renders a model from given cameras or along a path to PNG, .pfm or .mp4.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/evaluation/dynamic_share.h"
#include "recon4d/evaluation/metrics.h"
#include "recon4d/options/train_options.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/camera_paths/path_views.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/command.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/output_place.h"
#include "tools/cli/terminal.h"
#include "tools/clip/clip.h"
#include "tools/export/image_files.h"
#include "tools/session/locks.h"
#include "tools/session/output_folder.h"
#include "tools/video/video_encoder.h"

namespace tessera {
namespace {

constexpr size_t kViewsAtOnce = 4;
constexpr int kVideoQuality = 14;  // x264 crf: no difference to be seen beside the PNG

struct RenderRequest {
  std::string model, out, background, backend = "auto";
  CameraChoice choice;
  PathChoice path;  // without a path: the cameras as they are
  std::string fps = "30";
  int threads = 0;
  bool floats = false, alpha = false, dynamic_share = false, mp4 = false, overwrite = false,
       json = false;
};

std::vector<std::string> file_names(const std::vector<NamedView>& views, bool floats) {
  std::vector<std::string> files;
  for (const NamedView& view : views) {
    files.push_back(view.name + ".png");
    if (floats) files.push_back(view.name + ".pfm");
  }
  return files;
}

void write_files(const RenderRequest& request, const OutputFolder& folder, const std::string& name,
                 const RenderedImage& image) {
  if (request.floats) write_image_pfm(folder.path(name + ".pfm"), image);
  (request.alpha ? write_image_png_alpha : write_image_png)(folder.path(name + ".png"), image);
}

using ImageSink = std::function<void(const NamedView&, const RenderedImage&)>;

/// Renders a model, or a clip in windows, of which one is in memory.
class ClipRenderer {
 public:
  ClipRenderer(Backend& backend, const Clip& clip, bool background)
      : backend_(backend), models_(clip.windows), background_(background) {}

  /// Views from `begin` on: one or more, at most kViewsAtOnce, all of one window.
  std::vector<RenderedImage> render(const std::vector<NamedView>& views, size_t begin) {
    load(window_of(views[begin]));
    const size_t end = std::min(begin + kViewsAtOnce, views.size());
    std::vector<View> batch;
    for (size_t i = begin; i < end && window_of(views[i]) == window_; ++i) {
      batch.push_back(views[i].view);
      batch.back().time = window_time(models_.windows[size_t(window_)], batch.back().time);
    }
    return renderer_->render(batch);
  }
  /// The most Gaussians at once of what has been drawn.
  int64_t peak() const { return peak_; }

 private:
  int window_of(const NamedView& view) const { return window_at(models_.windows, view.view.time); }

  void load(int window) {
    if (window == window_) return;
    renderer_.reset();
    model_ = models_.load(window);
    window_ = window;
    peak_ = std::max(peak_, model_.count());
    renderer_.emplace(backend_, model_);
    if (!background_) renderer_->draw_no_background();
  }

  Backend& backend_;
  const WindowModels& models_;
  const bool background_;
  GaussianModel model_;
  int window_ = -1;
  int64_t peak_ = 0;
  std::optional<Renderer> renderer_;
};

/// Hands the images over in the order of the views.
void render_all(ClipRenderer& renderer, const std::vector<NamedView>& views,
                const ImageSink& sink) {
  ProgressBar bar("render");
  for (size_t i = 0; i < views.size();) {
    for (const RenderedImage& image : renderer.render(views, i)) {
      stop_if_interrupted();
      sink(views[i], image);
      bar.update(int64_t(i + 1), int64_t(views.size()), views[i].name);
      ++i;
    }
  }
}

nlohmann::json write_images(const RenderRequest& request, ClipRenderer& renderer,
                            const std::vector<NamedView>& views) {
  OutputFolder folder(request.out, "render", file_names(views, request.floats), request.overwrite);
  render_all(renderer, views, [&](const NamedView& named, const RenderedImage& image) {
    write_files(request, folder, named.name, image);
  });
  folder.finish();
  nlohmann::json frames = nlohmann::json::array();
  for (const NamedView& named : views) {
    nlohmann::json frame{{"name", named.name},
                         {"file", named.name + ".png"},
                         {"time", named.view.time},
                         {"width", named.view.camera.width},
                         {"height", named.view.camera.height}};
    if (request.floats) frame["float_file"] = named.name + ".pfm";
    frames.push_back(std::move(frame));
  }
  return {{"frames", std::move(frames)}};
}

nlohmann::json encode_views(ClipRenderer& renderer, const std::vector<NamedView>& views,
                            const FrameRate& fps, const std::filesystem::path& file) {
  const Camera& lens = views.front().view.camera;
  VideoEncoder encoder(file, {lens.width, lens.height, fps, kVideoQuality, VideoColour::kBt709});
  render_all(renderer, views, [&](const NamedView&, const RenderedImage& image) {
    encoder.add(quantise(image.planar(), image.width, image.height));
  });
  encoder.finish();
  return {{"file", file.string()},
          {"width", lens.width},
          {"height", lens.height},
          {"fps", fmt::format("{}/{}", fps.numerator, fps.denominator)},
          {"seconds", double(views.size()) / fps.value()},
          {"bytes", std::filesystem::file_size(file)}};
}

bool is_video_file(const std::filesystem::path& out) {
  return out.extension() == ".mp4" && !std::filesystem::is_directory(out);
}

/// OUT is the file itself when it ends in .mp4, else a folder for video.mp4.
nlohmann::json write_video(const RenderRequest& request, ClipRenderer& renderer,
                           const std::vector<NamedView>& views) {
  const std::filesystem::path out = request.out;
  if (is_video_file(out)) return encode_views(renderer, views, request.path.fps, out);
  OutputFolder folder(out, "render", {"video.mp4"}, request.overwrite);
  nlohmann::json result = encode_views(renderer, views, request.path.fps, folder.path("video.mp4"));
  folder.finish();
  result["file"] = (out / "video.mp4").string();
  return result;
}

/// Images of a prepared scene may be small, by --scale, and a video of them comes out no larger.
void say_small(const PathChoice& path, const Camera& lens) {
  constexpr int kLarge = 1280;  // pixels of the longer side
  const int longer = std::max(lens.width, lens.height);
  if (!path.size.empty() || longer >= kLarge) return;
  const auto even = [&](int side) { return int(std::lround(0.5 * kLarge * side / longer)) * 2; };
  say(fmt::format("render: draws {}x{}, the size of the scene's images; --size {}x{} for more",
                  lens.width, lens.height, even(lens.width), even(lens.height)));
}

/// Checks what can be checked before a model is read.
void check_request(RenderRequest& request) {
  if (request.mp4 && !video_encoder_available())
    throw InputError(
        "render: this build has no FFmpeg: leave --mp4 out, or build with TESSERA_INGEST=ON");
  if (request.path.path.empty() && request.choice.cameras.empty())
    throw InputError("render: no cameras; pass --cameras SCENE or --path orbit");
  request.path.fps = parse_frame_rate("render", request.fps);
  request.path.cameras = request.choice.cameras;
  request.path.split = request.choice.split;
  request.path.time = request.choice.time;
  request.path.for_video = request.mp4;
  if (!request.path.path.empty()) check_path_choice(request.path);
  if (!request.choice.split.empty()) parse_split(request.choice.split);
  if (!request.background.empty()) parse_background(request.background);
  if (const auto time = request.choice.time; time && !(*time >= 0 && *time <= 1))
    throw InputError(fmt::format("render: --time is {}, expected 0 (first) to 1 (last)", *time));
  if (request.mp4 && is_video_file(request.out) && std::filesystem::exists(request.out) &&
      !request.overwrite)
    throw InputError(
        fmt::format("{}: is there already; choose another file or pass --overwrite", request.out));
}

int render(RenderRequest request) {
  check_request(request);
  set_thread_count(request.threads);
  Clip clip = load_clip(request.model);
  check_output_of_model(request.out, clip.named, request.choice.cameras);
  const SceneLock in_use(request.choice.cameras, SceneLock::Use::kRead);
  const std::vector<NamedView> views =
      request.path.path.empty()
          ? read_views(request.choice, *clip.head)
          : path_views(request.path,
                       {*clip.head, clip.named, is_of_other_program(model_kind(clip.file))},
                       clip.warnings);
  for (const std::string& warning : clip.warnings) warn(warning);
  if (!request.path.path.empty()) say_small(request.path, views.front().view.camera);
  clip.edit([&](GaussianModel& model) {
    replace_background(request.background, model);
    if (request.dynamic_share) model = dynamic_set_white(model);
  });
  const std::unique_ptr<Backend> backend = make_backend(request.backend);
  ClipRenderer renderer(*backend, clip, !request.alpha);
  nlohmann::json result =
      request.mp4 ? write_video(request, renderer, views) : write_images(request, renderer, views);
  result.update({{"out", request.out},
                 {"model", clip.file.string()},
                 {"num_gaussians", renderer.peak()},
                 {"background", clip.head->background},
                 {"backend", backend->name()},
                 {"count", views.size()}});
  if (clip.count() > 1) result["windows"] = clip.count();
  print_result(request.json, result,
               fmt::format("{}: {} images of {}{} Gaussians", request.out, views.size(),
                           clip.count() > 1 ? "at most " : "", renderer.peak()));
  return kExitDone;
}

void add_path_options(CLI::App& command, RenderRequest& request) {
  CLI::Option* path = command.add_option(
      "--path", request.path.path,
      "a moving camera: orbit (around what the cameras look at), spiral (before it), or a "
      "transforms file of key frames");
  const auto of_path = [path](CLI::Option* option) {
    option->needs(path);
    return option;
  };
  of_path(command.add_option("--fps", request.fps, "frames a second, 30 or 30000/1001"));
  of_path(command.add_option("--seconds", request.path.seconds,
                             "length; default: whole rounds of the clip, 6 to 60; of key frames: "
                             "each one once"));
  of_path(
      command.add_option("--size", request.path.size, "WxH, pixels; default: of the first camera"));
  CLI::Option* rate =
      of_path(command.add_option("--rate", request.path.rate, "speed of the clip; default: 1"));
  CLI::Option* mp4 = of_path(
      command.add_flag("--mp4", request.mp4, "one video: OUT.mp4, or video.mp4 in the folder OUT"));
  rate->excludes(command.get_option("--time"));
  mp4->excludes(command.get_option("--float"));
  mp4->excludes(command.get_option("--alpha"));
}

}  // namespace

void add_render_command(CLI::App& app, Work& work) {
  CLI::App* command =
      app.add_subcommand("render", "render images or a video from given cameras or along a path");
  command->option_defaults()->always_capture_default();
  const auto request = std::make_shared<RenderRequest>();
  command
      ->add_option("model", request->model,
                   "output of `tessera run`, run folder, folder of windows, checkpoint, 3DGS or "
                   "Tessera .ply")
      ->required();
  command->add_option(
      "--cameras", request->choice.cameras,
      "scene folder, or a transforms file as camera path (its images need not exist); one "
      "without a `tessera` object is in the capture's own world; with --path the rig of orbit and "
      "spiral, by default the scene that the run folder names");
  command->add_option("-o,--out", request->out, "folder of the images, or file of the video")
      ->required();
  command->add_option("--split", request->choice.split, "train, val or test; default: all frames");
  command->add_option("--time", request->choice.time,
                      "one timestep for all images, 0 (first) to 1 (last)");
  command->add_option("--background", request->background,
                      "black, white or r,g,b; default: the model's");
  command->add_flag("--alpha", request->alpha, "RGBA PNG without background");
  command
      ->add_flag(
          "--dynamic-share", request->dynamic_share,
          "not colours but how much of each pixel's light is of dynamic Gaussians, 0 (black) "
          "to 1 (white)")
      ->excludes("--background")
      ->excludes("--alpha");
  command->add_flag("--float", request->floats, "also unclamped floats as .pfm");
  add_path_options(*command, *request);
  command->add_flag("--overwrite", request->overwrite, "write among files that are not ours");
  add_backend_options(*command, request->backend);
  command->add_option("--threads", request->threads, "CPU threads; 0: all");
  command->add_flag("--json", request->json, "print one JSON object");
  command->callback([&work, request] { work = [request] { return render(*request); }; });
}

}  // namespace tessera
