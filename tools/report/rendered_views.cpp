// One model and its frames are in memory.
#include "tools/report/rendered_views.h"

#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "kernels/base/errors.h"
#include "recon4d/evaluation/evaluate.h"
#include "recon4d/evaluation/metrics.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/model/model_file.h"
#include "recon4d/training/scene_scale.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/session/locks.h"
#include "tools/session/run_folder.h"

namespace tessera {

namespace fs = std::filesystem;

struct RenderedViews::Loaded {
  Loaded(fs::path folder, GaussianModel its_model, Scene its_scene, Backend& backend)
      : run(std::move(folder)),
        model(std::move(its_model)),
        scene(std::move(its_scene)),
        renderer(backend, model) {
    for (const Frame& frame : scene.frames) frames[frame.name] = &frame;
  }

  const fs::path run;
  const GaussianModel model;
  const Scene scene;
  Renderer renderer;
  std::map<std::string, const Frame*> frames;
};

RenderedViews::RenderedViews(const fs::path& run,
                             const std::function<std::unique_ptr<Backend>()>& backend)
    : root_(run), windows_{run} {
  if (windows_.exists()) {
    const WindowsPlan plan = windows_.read();
    require_all_windows(windows_, plan);
    parts_ = plan.windows;
    scene_ = scene_of_windows(windows_, plan);
  } else {
    if (!fs::exists(RunFolder{run}.model()))
      throw InputError("There is no model yet, so that no view can be rendered.");
    scene_ = scene_of_model(run);
    if (scene_.empty() || !fs::exists(scene_))
      throw InputError("The scene of this run is gone, so that no view can be rendered.");
  }
  const fs::path trained = parts_.empty() ? root_ : windows_.window_run(0);
  if (const std::string changed = changed_scene(trained, scene_.string()); !changed.empty())
    throw InputError(changed);
  backend_ = backend();
  if (parts_.empty()) load(root_);
}

RenderedViews::~RenderedViews() = default;

RenderedViews::Loaded& RenderedViews::load(const fs::path& run) {
  if (loaded_ && loaded_->run == run) return *loaded_;
  loaded_.reset();
  const SceneLock in_use(scene_, SceneLock::Use::kRead);
  GaussianModel model = load_model(RunFolder{run}.model());
  Scene scene =
      scaled_scene(scene_for(model, run, scene_, {.held_out = std::numeric_limits<int64_t>::max()}),
                   model.train_scale);
  loaded_ = std::make_unique<Loaded>(run, std::move(model), std::move(scene), *backend_);
  return *loaded_;
}

nlohmann::json RenderedViews::scores(const WindowsScorer& of_windows) {
  if (!parts_.empty()) return of_windows ? of_windows(*backend_, windows_) : nullptr;
  const Loaded& run = load(root_);
  if (run.scene.frames.empty()) return nullptr;
  return to_json(
      evaluate(*backend_, run.model, run.scene, run.scene.frames.front().split, EvaluateOptions{}),
      run.model);
}

std::optional<RenderedView> RenderedViews::view(const ScoredView& view) {
  Loaded& run = load(parts_.empty() ? root_ : windows_.window_run(window_at(parts_, view.time)));
  const auto found = run.frames.find(view.name);
  if (found == run.frames.end()) return std::nullopt;
  const Frame& frame = *found->second;
  const RenderedImage image = run.renderer.render({{frame.camera, frame.time}}).front();
  return RenderedView{frame.image, quantise(image.planar(), image.width, image.height),
                      frame.mask.image()};
}

}  // namespace tessera
