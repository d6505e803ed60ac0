// One window after another is in memory.
#include "tools/windows/windows_scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "ingest/prepared/scene_reader.h"
#include "ingest/prepared/transforms_json.h"
#include "recon4d/evaluation/border_scores.h"
#include "recon4d/training/scene_scale.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/session/static_model.h"
#include "tools/windows/joined_report.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct SplitOfClip {
  JoinedReport report;
  BorderMeter borders;
};

/// Images and masks at the size of the model; none where there is no such scene.
std::vector<Frame> stills_of(const fs::path& still_scene, double scale) {
  if (!is_prepared_scene(still_scene)) return {};
  SceneOptions options;
  options.allow_static = true;
  return scaled_scene(load_scene(still_scene, options), scale).frames;
}

}  // namespace

json score_windows(Backend& backend, const WindowModels& models, const fs::path& scene_folder,
                   const std::vector<Split>& splits, const EvaluateOptions& options,
                   const fs::path& still_scene) {
  std::map<Split, SplitOfClip> of_clip;
  GaussianModel rules;  // the last model: its static set and rules are those of all
  int64_t dynamic = 0, most = 0;
  const auto count = int64_t(models.windows.size());
  ProgressBar bar("evaluate");
  for (int64_t i = 0; i < count; ++i) {
    GaussianModel model = models.load(int(i));
    SceneOptions core{.pixels_of = splits};
    core.window = Window{i, count, 0};
    Scene scene = scaled_scene(scene_for(model, {}, scene_folder, core), model.train_scale);
    scene.stills = stills_of(still_scene, model.train_scale);
    take_light(scene, scene.stills);
    const Interval time = models.windows[size_t(i)].time;
    for (const Split split : splits) {
      if (scene.split_indices(split).empty()) continue;
      SplitOfClip& clip = of_clip[split];
      clip.borders.begin_window();
      clip.report.add(evaluate(backend, model, scene, split, options,
                               [&](const Frame& frame, const RenderedImage& image,
                                   const ViewScore& score, int64_t, int64_t) {
                                 stop_if_interrupted();
                                 clip.borders.add(frame, image);
                                 bar.update(i, count, fmt::format("{:.2f} dB", score.psnr));
                               }),
                      time.low, time.high - time.low);
    }
    dynamic += model.dynamic_set.count();
    most = std::max(most, model.dynamic_set.count());
    if (i + 1 == count) rules = std::move(model);
  }
  bar.clear();
  json result = json::object(), all = json::object();
  for (const Split split : splits) {
    const auto found = of_clip.find(split);
    if (found == of_clip.end()) continue;
    json scores = to_json(found->second.report.finish(), rules);
    scores["windows"] = models.windows.size();
    scores["num_dynamic"] = dynamic;
    scores["num_gaussians"] = rules.static_set.count() + dynamic;
    scores["peak_gaussians"] = rules.static_set.count() + most;
    scores["borders"] = to_json(found->second.borders.score());
    if (all.empty()) result = scores;
    all[name_of(split)] = std::move(scores);
  }
  if (!all.empty()) result["splits"] = std::move(all);
  return result;
}

json score_windows(Backend& backend, const WindowsFolder& folder, const std::vector<Split>& splits,
                   const EvaluateOptions& options) {
  const WindowModels models = clip_models(folder).windows;
  return score_windows(backend, models, scene_of_windows(folder, folder.read()), splits, options,
                       folder.static_scene());
}

}  // namespace tessera
