// The model of one window and its frames are in memory.
#include "tools/report/rendered_views.h"

#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "kernels/base/errors.h"
#include "recon4d/evaluation/metrics.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/training/scene_scale.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/clip/clip_scores.h"
#include "tools/session/held_out_scores.h"
#include "tools/session/locks.h"
#include "tools/session/model_scene.h"
#include "tools/session/run_folder.h"
#include "tools/session/windows_folder.h"

namespace tessera {

namespace fs = std::filesystem;

struct RenderedViews::Loaded {
  Loaded(int index, GaussianModel its_model, Scene its_scene, Backend& backend)
      : window(index),
        model(std::move(its_model)),
        scene(std::move(its_scene)),
        renderer(backend, model) {
    for (const Frame& frame : scene.frames) frames[frame.name] = &frame;
  }

  const int window;
  const GaussianModel model;
  const Scene scene;
  Renderer renderer;
  std::map<std::string, const Frame*> frames;
};

RenderedViews::RenderedViews(const fs::path& run,
                             const std::function<std::unique_ptr<Backend>()>& backend)
    : scene_(scene_of_model(run)) {
  if (!WindowsFolder{run}.exists() && !fs::exists(RunFolder{run}.model()))
    throw InputError("There is no model yet, so that no view can be rendered.");
  clip_ = load_clip(run);
  if (!fs::exists(scene_))
    throw InputError("The scene of this run is gone, so that no view can be rendered.");
  if (const std::string changed = changed_scene(run, scene_.string()); !changed.empty())
    throw InputError(changed);
  backend_ = backend();
}

RenderedViews::~RenderedViews() = default;

RenderedViews::Loaded& RenderedViews::load(int window) {
  if (loaded_ && loaded_->window == window) return *loaded_;
  loaded_.reset();
  const SceneLock in_use(scene_, SceneLock::Use::kRead);
  GaussianModel model = clip_.windows.load(window);
  SceneOptions options{.held_out = std::numeric_limits<int64_t>::max()};
  if (clip_.count() > 1) options.window = Window{window, clip_.count(), 0};
  Scene scene = scaled_scene(scene_for(model, clip_.named, scene_, options), model.train_scale);
  loaded_ = std::make_unique<Loaded>(window, std::move(model), std::move(scene), *backend_);
  return *loaded_;
}

nlohmann::json RenderedViews::scores() {
  const SceneLock in_use(scene_, SceneLock::Use::kRead);
  std::vector<Split> splits =
      held_out_splits(scene_for(*clip_.head, clip_.named, scene_, {.load_pixels = false}));
  if (splits.empty()) splits = {Split::kTrain};
  return score_clip(*backend_, clip_, scene_, {splits.front()});
}

std::optional<RenderedView> RenderedViews::view(const ScoredView& view) {
  Loaded& run = load(window_at(clip_.windows.windows, view.time));
  const auto found = run.frames.find(view.name);
  if (found == run.frames.end()) return std::nullopt;
  const Frame& frame = *found->second;
  const RenderedImage image = run.renderer.render({{frame.camera, frame.time}}).front();
  return RenderedView{frame.image, quantise(image.planar(), image.width, image.height),
                      frame.mask.image()};
}

}  // namespace tessera
