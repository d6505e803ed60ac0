// What: `tessera render`: a model seen from given cameras → PNG, .pfm.
// Not: the renderer (recon4d/render.h).
#include <fmt/format.h>

#include <algorithm>

#include "kernels/base/parallel.h"
#include "recon4d/train_options.h"
#include "tools/backend_choice.h"
#include "tools/camera_views.h"
#include "tools/command.h"
#include "tools/interrupt.h"
#include "tools/model_input.h"
#include "tools/output_folder.h"
#include "tools/picture_files.h"
#include "tools/terminal.h"

namespace tessera {
namespace {

constexpr size_t kViewsAtOnce = 4;

struct RenderRequest {
  std::string model, out, background, backend = "auto";
  CameraChoice choice;
  int threads = 0;
  bool floats = false, alpha = false, overwrite = false, json = false;
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
                 const Picture& picture) {
  if (request.floats) write_picture_pfm(folder.path(name + ".pfm"), picture);
  (request.alpha ? write_picture_png_alpha : write_picture_png)(folder.path(name + ".png"),
                                                                picture);
}

void render_all(Renderer& renderer, const std::vector<NamedView>& views,
                const RenderRequest& request, const OutputFolder& folder) {
  ProgressBar bar("render");
  for (size_t begin = 0; begin < views.size(); begin += kViewsAtOnce) {
    const size_t end = std::min(begin + kViewsAtOnce, views.size());
    std::vector<View> batch;
    for (size_t i = begin; i < end; ++i) batch.push_back(views[i].view);
    const std::vector<Picture> pictures = renderer.render(batch);
    for (size_t i = begin; i < end; ++i) {
      stop_if_interrupted();
      write_files(request, folder, views[i].name, pictures[i - begin]);
      bar.update(int64_t(i + 1), int64_t(views.size()), views[i].name);
    }
  }
}

nlohmann::json result_json(const RenderRequest& request, const ModelInput& input,
                           const std::vector<NamedView>& views, const std::string& backend) {
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
  return {{"out", request.out},
          {"model", input.file.string()},
          {"num_gaussians", input.model.count()},
          {"background", input.model.background},
          {"backend", backend},
          {"count", views.size()},
          {"frames", std::move(frames)}};
}

int render(const RenderRequest& request) {
  set_thread_count(request.threads);
  ModelInput input = load_model_input(request.model);
  for (const std::string& warning : input.warnings) warn(warning);
  replace_background(request.background, input.model);
  const std::vector<NamedView> views = read_views(request.choice, input.model);
  const std::unique_ptr<Backend> backend = make_backend(request.backend);
  OutputFolder folder(request.out, "render", file_names(views, request.floats), request.overwrite);
  Renderer renderer(*backend, input.model);
  if (request.alpha) renderer.draw_no_background();
  render_all(renderer, views, request, folder);
  folder.finish();
  print_result(request.json, result_json(request, input, views, backend->name()),
               fmt::format("{}: {} pictures of {} Gaussians", request.out, views.size(),
                           input.model.count()));
  return kExitDone;
}

}  // namespace

void add_render_command(CLI::App& app, Work& work) {
  CLI::App* command = app.add_subcommand("render", "draw a model from given cameras");
  command->option_defaults()->always_capture_default();
  const auto request = std::make_shared<RenderRequest>();
  command->add_option("model", request->model, "run folder, checkpoint, 3DGS or Tessera .ply")
      ->required();
  command
      ->add_option(
          "--cameras", request->choice.cameras,
          "scene folder, or a transforms file as camera path (its pictures need not exist); one "
          "without a `tessera` object is in the capture's own world")
      ->required();
  command->add_option("-o,--out", request->out, "folder of the pictures")->required();
  command->add_option("--split", request->choice.split, "train, val or test; default: all frames");
  command->add_option("--time", request->choice.time,
                      "one moment for all pictures, 0 (first) to 1 (last)");
  command->add_option("--background", request->background,
                      "black, white or r,g,b; default: the model's");
  command->add_flag("--alpha", request->alpha, "RGBA PNG without background");
  command->add_flag("--float", request->floats, "also unclamped floats as .pfm");
  command->add_flag("--overwrite", request->overwrite, "write among files that are not ours");
  command->add_option("--backend", request->backend,
                      "auto (a CUDA device where there is one), cpu or cuda");
  command->add_option("--threads", request->threads, "CPU threads; 0: all");
  command->add_flag("--json", request->json, "print one JSON object");
  command->callback([&work, request] { work = [request] { return render(*request); }; });
}

}  // namespace tessera
