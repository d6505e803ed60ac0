// One window after another is in memory.
#include "tools/windows/windows_scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "recon4d/evaluation/border_scores.h"
#include "recon4d/model/model_file.h"
#include "recon4d/training/scene_scale.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/session/run_folder.h"
#include "tools/windows/joined_report.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct SplitOfClip {
  JoinedReport report;
  BorderMeter borders;
};

}  // namespace

json score_windows(Backend& backend, const WindowsFolder& folder, const std::vector<Split>& splits,
                   const EvaluateOptions& options) {
  const WindowsPlan plan = folder.read();
  require_all_windows(folder, plan);
  const fs::path path = scene_of_windows(folder, plan);
  std::map<Split, SplitOfClip> of_clip;
  GaussianModel rules;  // the last model: its static set and rules are those of all
  int64_t dynamic = 0, most = 0;
  const auto count = int64_t(plan.windows.size());
  ProgressBar bar("evaluate");
  for (int64_t i = 0; i < count; ++i) {
    const RunFolder run{folder.window_run(i)};
    GaussianModel model = load_model(run.model());
    const Scene scene =
        scaled_scene(scene_for(model, run.root, path, {.pixels_of = splits}), model.train_scale);
    const Interval time = plan.windows[size_t(i)].time;
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
    scores["windows"] = plan.windows.size();
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

}  // namespace tessera
