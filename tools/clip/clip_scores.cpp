// One window after another is in memory.
#include "tools/clip/clip_scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "ingest/prepared/scene_reader.h"
#include "ingest/prepared/transforms_json.h"
#include "recon4d/training/scene_scale.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/clip/border_scores.h"
#include "tools/clip/joined_report.h"
#include "tools/session/held_out_scores.h"
#include "tools/session/static_model.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct SplitOfClip {
  JoinedReport report;
  BorderMeter borders;
};

/// How many Gaussians a clip has.
struct Counts {
  int64_t fixed = 0, dynamic = 0, most_dynamic = 0;

  void add(const GaussianModel& model) {
    fixed = model.static_set.count();
    dynamic += model.dynamic_set.count();
    most_dynamic = std::max(most_dynamic, model.dynamic_set.count());
  }
};

/// The frames of a window's core, at the size that is scored.
Scene scene_of_window(const Clip& clip, const GaussianModel& model, int64_t window,
                      const fs::path& folder, const std::vector<Split>& splits, double scale) {
  SceneOptions core{.pixels_of = splits};
  if (clip.count() > 1) core.window = Window{window, clip.count(), 0};
  const double of_images = truth_scale(scale, model.train_scale);
  Scene scene = scaled_scene(scene_for(model, clip.named, folder, core), of_images);
  if (!is_prepared_scene(clip.stills)) return scene;
  SceneOptions still;
  still.allow_static = true;
  scene.stills = scaled_scene(load_scene(clip.stills, still), of_images).frames;
  take_light(scene, scene.stills);
  return scene;
}

}  // namespace

json score_clip(Backend& backend, const Clip& clip, const fs::path& scene_folder,
                const std::vector<Split>& splits, const EvaluateOptions& options, double scale,
                const ScoredCallback& scored) {
  std::map<Split, SplitOfClip> of_clip;
  Counts counts;
  const int64_t windows = clip.count();
  ProgressBar bar("evaluate");
  for (int64_t i = 0; i < windows; ++i) {
    const GaussianModel model = clip.windows.load(int(i));
    counts.add(model);
    const Scene scene = scene_of_window(clip, model, i, scene_folder, splits, scale);
    const Interval time = clip.windows.windows[size_t(i)].time;
    for (const Split split : splits) {
      if (scene.split_indices(split).empty()) continue;
      SplitOfClip& parts = of_clip[split];
      parts.borders.begin_window();
      const auto with_view = [&](const Frame& frame, const RenderedImage& image,
                                 const ViewScore& score, int64_t done, int64_t total) {
        stop_if_interrupted();
        if (windows > 1) parts.borders.add(frame, image);
        if (scored) scored(frame, image, score, done, total);
        bar.update(i * total + done, windows * total,
                   fmt::format("{} {:.2f} dB", name_of(split), score.psnr));
      };
      parts.report.add(evaluate(backend, model, scene, split, options, with_view), time.low,
                       time.high - time.low);
    }
  }
  bar.clear();
  return by_split(splits, [&](Split split) -> json {
    const auto found = of_clip.find(split);
    if (found == of_clip.end()) return nullptr;
    EvaluationReport report = found->second.report.finish();
    report.bytes = clip.bytes;
    json scores = to_json(report, *clip.head);
    scores["num_dynamic"] = counts.dynamic;
    scores["num_gaussians"] = counts.fixed + counts.dynamic;
    if (windows == 1) return scores;
    scores["windows"] = windows;
    scores["peak_gaussians"] = counts.fixed + counts.most_dynamic;
    scores["borders"] = to_json(found->second.borders.score());
    return scores;
  });
}

}  // namespace tessera
