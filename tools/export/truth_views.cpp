// Reads few frames of the scene, makes them smaller and encodes them for a page.
#include "tools/export/truth_views.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "ingest/files/png.h"
#include "kernels/base/errors.h"
#include "recon4d/training/scene_scale.h"
#include "static3d/tessera4d/player_hints.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/player/page_words.h"
#include "tools/session/run_folder.h"
#include "tools/video/jpeg.h"

namespace tessera {
namespace {

constexpr int64_t kMostViews = 6;
constexpr int kMostWidth = 960;  // pixels
constexpr int kQuantiser = 4;    // of JPEG

std::string image_address(const Image8& image) {
  Image8 small = image;
  if (image.width > kMostWidth) {
    const double height = double(kMostWidth) * image.height / image.width;
    small = averaged_image(image, kMostWidth, std::max(1, int(std::lround(height))));
  }
  if (const auto bytes = jpeg_bytes(small, kQuantiser)) return data_address("image/jpeg", *bytes);
  const TemporaryFolder folder("truth");
  write_png(folder.path() / "truth.png", small);
  return data_address("image/png", read_text_file(folder.path() / "truth.png"));
}

}  // namespace

nlohmann::json truth_views(const ExportRequest& request, const GaussianModel& model) {
  const std::filesystem::path place =
      request.cameras.empty() ? scene_of_model(request.model) : request.cameras;
  if (place.empty())
    throw InputError(
        "export: --truth needs the scene's images, and the model's scene is not there; pass the "
        "scene as --cameras");
  nlohmann::json views = nlohmann::json::array();
  for (const Frame& frame : scene_for(model, place, kMostViews).frames)
    views.push_back({{"name", frame.name},
                     {"camera", camera_json({frame.name, frame.camera})},
                     {"t", frame.time},
                     {"image", image_address(frame.image)}});
  return views;
}

}  // namespace tessera
