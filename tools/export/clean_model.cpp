// Draws the model for the cameras of its training, wherever the backend of this machine is.
#include "tools/export/clean_model.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "recon4d/reduction/floaters.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/cli/backend_options.h"
#include "tools/session/model_scene.h"

namespace tessera {
namespace {

/// A page's cameras may be a camera path, so the model's scene comes before them. Empty
/// where neither is there.
std::filesystem::path scene_of_training(const ExportRequest& request) {
  if (std::filesystem::is_directory(request.cameras)) return request.cameras;
  const std::filesystem::path scene = scene_of_model(request.model);
  return scene.empty() ? std::filesystem::path(request.cameras) : scene;
}

}  // namespace

std::optional<int64_t> clean_model(const std::filesystem::path& scene, GaussianModel& model) {
  CameraChoice choice;
  choice.cameras = scene;
  choice.split = "train";
  std::vector<View> training;
  for (const NamedView& named : find_views(choice, model)) training.push_back(named.view);
  const CameraViews cameras = views_of_support(training);
  if (int(cameras.size()) < kLeastPlaces) return std::nullopt;
  const std::unique_ptr<Backend> backend = make_backend("auto");
  return remove_marked(find_floaters(model, measure_support(*backend, model, cameras)), model);
}

nlohmann::json clean_if_asked(const ExportRequest& request, Clip& clip) {
  const bool page = request.page || request.format == "page" || request.format == "html";
  if (!request.clean.value_or(page)) return nullptr;
  if (clip.count() > 1) {
    if (!request.clean) return nullptr;
    throw InputError(fmt::format(
        "export: --clean is of one model, and {} has {} windows, which share their static "
        "Gaussians; leave it out",
        request.model, clip.count()));
  }
  const std::filesystem::path scene = scene_of_training(request);
  if (scene.empty()) {
    if (!request.clean) return nullptr;
    throw InputError(
        "export: --clean needs the cameras of the training, and the model's scene is not there; "
        "pass the scene as --cameras");
  }
  try {
    if (const std::optional<int64_t> removed = clean_model(scene, *clip.head)) return *removed;
  } catch (const InputError&) {
    if (request.clean) throw;
    return nullptr;  // a scene that has changed since is not required
  }
  if (!request.clean) return nullptr;
  throw InputError(
      fmt::format("{}: its training cameras stand in fewer than {} places, so that no Gaussian is "
                  "known to be a floater; leave --clean out",
                  scene.string(), kLeastPlaces));
}

}  // namespace tessera
