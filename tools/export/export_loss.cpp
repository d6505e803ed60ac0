// Renders view by view: the written file may be as large as memory allows.
#include "tools/export/export_loss.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "ingest/files/json_file.h"
#include "recon4d/evaluation/metrics.h"
#include "recon4d/evaluation/render.h"
#include "static3d/formats/splat_file.h"
#include "static3d/line_motion/line_formats.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/camera_paths/path_views.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/interrupt.h"
#include "tools/export/line_export.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kLossWidth = 640;
constexpr size_t kLossViews = 20;

Camera smaller(Camera camera) {
  if (camera.width <= kLossWidth) return camera;
  return camera.resized(kLossWidth, std::max(1, kLossWidth * camera.height / camera.width));
}

/// Of `places` views the i-th of `count`, evenly.
size_t spread(size_t i, size_t count, size_t places) {
  return i * places / std::max<size_t>(count, 1);
}

Image8 drawn(Backend& backend, const GaussianModel& model, const View& view) {
  const RenderedImage image = render_views(backend, model, {view}).at(0);
  return quantise(image.planar(), image.width, image.height);
}

/// The rules that players of 3DGS files have, as these name none.
DrawingRules players_rules(const DrawingRules& of) {
  DrawingRules rules = of;
  const DrawingRules usual;
  rules.filter_2d = usual.filter_2d;
  rules.truncation_sigma = usual.truncation_sigma;
  rules.truncation_by_falloff = usual.truncation_by_falloff;
  rules.sliced_direction = usual.sliced_direction;
  return rules;
}

std::vector<View> loss_views(const ExportRequest& request, const GaussianModel& model,
                             const std::vector<double>& times) {
  std::vector<Camera> cameras;
  for (const PlayerCamera& camera : rig_of(request.cameras, request.model, model).cameras)
    cameras.push_back(smaller(camera.camera));
  if (cameras.empty()) {
    PathChoice orbit;
    orbit.path = "orbit";
    orbit.seconds = 1;
    orbit.time = 0;
    std::vector<std::string> warnings;
    for (const NamedView& view : path_views(orbit, {model, request.model, true}, warnings))
      cameras.push_back(smaller(view.view.camera));
  }
  const size_t count = times.empty() ? kLossViews : std::min(kLossViews, times.size());
  std::vector<View> views;
  for (size_t i = 0; i < count; ++i) {
    const double time =
        times.empty() ? (double(i) + 0.5) / double(count) : times[spread(i, count, times.size())];
    views.push_back({cameras[spread(i, count, cameras.size())], time});
  }
  return views;
}

/// What an export has left in its folder.
class WrittenFiles {
 public:
  virtual ~WrittenFiles() = default;
  /// Normalised timesteps that it has, ascending; empty: all.
  virtual std::vector<double> times() const { return {}; }
  /// What is drawn at one of these.
  virtual GaussianModel& at(double time) = 0;
};

class WrittenLines : public WrittenFiles {
 public:
  explicit WrittenLines(const fs::path& file) : model_(load_line_file(file).model) {}
  GaussianModel& at(double) override { return model_; }

 private:
  GaussianModel model_;
};

class WrittenFrames : public WrittenFiles {
 public:
  explicit WrittenFrames(const fs::path& folder) : folder_(folder) {
    const json manifest = read_json(folder / "manifest.json");
    for (const json& frame : manifest.at("frames"))
      files_[frame.at("time").get<double>()] = frame.at("file").get<std::string>();
  }
  std::vector<double> times() const override {
    std::vector<double> times;
    for (const auto& [time, file] : files_) times.push_back(time);
    return times;
  }
  GaussianModel& at(double time) override {
    frame_ = model_of(load_splat_file(folder_ / files_.at(time)));
    return frame_;
  }

 private:
  fs::path folder_;
  std::map<double, std::string> files_;
  GaussianModel frame_;
};

/// Nothing of the Tessera 4D file, whose bounds of errors are stated, and of what is not read.
std::unique_ptr<WrittenFiles> written_files(const ExportRequest& request) {
  if (const LineFormat* const lines = find_line_format(request.format); lines && lines->is_read)
    return std::make_unique<WrittenLines>(line_file_of(request.out, *lines));
  if (find_time_format(request.format) != nullptr) return nullptr;
  return std::make_unique<WrittenFrames>(request.out);
}

/// A window of the clip after the other.
class DrawnClip {
 public:
  DrawnClip(Backend& backend, const Clip& clip) : backend_(backend), clip_(clip) {}
  Image8 at(const View& view) {
    const std::vector<FileWindow>& windows = clip_.windows.windows;
    const int window = window_at(windows, view.time);
    if (window != loaded_) model_ = clip_.windows.load(window);
    loaded_ = window;
    return drawn(backend_, *model_, {view.camera, window_time(windows[size_t(window)], view.time)});
  }

 private:
  Backend& backend_;
  const Clip& clip_;
  std::optional<GaussianModel> model_;
  int loaded_ = -1;
};

}  // namespace

json export_loss(const ExportRequest& request, const Clip& clip) {
  const std::unique_ptr<WrittenFiles> files = written_files(request);
  if (!files) return json::object();
  const std::vector<View> views = loss_views(request, *clip.head, files->times());
  const std::unique_ptr<Backend> backend = make_backend("auto");
  DrawnClip truth(*backend, clip);
  double by_rules = 0, by_players = 0;
  for (const View& view : views) {
    stop_if_interrupted();
    const Image8 image = truth.at(view);
    GaussianModel& model = files->at(view.time);
    model.background = clip.head->background;
    const int degree = model.drawing.sh_degree;
    model.drawing = clip.head->drawing;
    model.drawing.sh_degree = degree;
    by_rules += mean_squared_error(image, drawn(*backend, model, view));
    model.drawing = players_rules(model.drawing);
    by_players += mean_squared_error(image, drawn(*backend, model, view));
  }
  const auto count = double(views.size());
  return {{"views", views.size()},
          {"psnr", psnr_of_mse(by_rules / count)},
          {"psnr_players", psnr_of_mse(by_players / count)}};
}

std::string loss_text(const json& result) {
  if (!result.contains("psnr")) return "";
  const double rules = result["psnr"], players = result["psnr_players"];
  std::string text = fmt::format(", {:.1f} dB against the model", rules);
  if (std::abs(rules - players) >= 0.05)
    text += fmt::format(", {:.1f} dB where a player draws without antialiasing", players);
  return text;
}

}  // namespace tessera
