// Chooses the camera, renders it in the size of a poster, and encodes the image.
#include "tools/export/poster_view.h"

#include <algorithm>
#include <cmath>

#include "ingest/files/atomic_file.h"
#include "ingest/files/temporary_folder.h"
#include "kernels/base/errors.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/image_files.h"
#include "tools/session/run_folder.h"

namespace tessera {
namespace {

constexpr int kLongestSide = 800;  // pixels

View first_view(CameraChoice choice, const GaussianModel& model) {
  choice.split = "test";
  try {
    return read_views(choice, model).front().view;
  } catch (const InputError&) {  // no test split; what cannot be read fails again
    choice.split.clear();
    return read_views(choice, model).front().view;
  }
}

Camera poster_camera(const Camera& camera) {
  const double scale = double(kLongestSide) / std::max(camera.width, camera.height);
  if (scale >= 1) return camera;
  const auto side = [&](int pixels) { return std::max(1, int(std::lround(scale * pixels))); };
  return camera.resized(side(camera.width), side(camera.height));
}

}  // namespace

std::string poster_view(const ExportRequest& request, const GaussianModel& model) {
  CameraChoice choice;
  choice.cameras = request.cameras.empty() ? scene_of_model(request.model) : request.cameras;
  choice.time = 0.0;
  if (choice.cameras.empty())
    throw InputError(
        "export: --poster auto needs a camera, and the model's scene is not there; pass --cameras, "
        "or an image file as --poster");
  View view = first_view(choice, model);
  view.camera = poster_camera(view.camera);
  const std::unique_ptr<Backend> backend = make_backend("auto");
  const RenderedImage image = render_views(*backend, model, {view}).front();
  const TemporaryFolder folder("poster");
  write_image_png(folder.path() / "poster.png", image);
  return read_text_file(folder.path() / "poster.png");
}

}  // namespace tessera
