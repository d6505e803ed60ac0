// Chooses the frames, renders them and keeps the images.
#include "tools/batch/held_out_views.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "ingest/files/png.h"
#include "kernels/base/errors.h"
#include "recon4d/evaluation/metrics.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/model/model_file.h"
#include "recon4d/training/scene_scale.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/session/locks.h"
#include "tools/session/run_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kWidth = 200;  // pixels, at most

fs::path image_file(const fs::path& folder, size_t i, const char* kind) {
  return folder / fmt::format("{}_{}.png", i, kind);
}

/// Those that are kept; none where they are of another model or number.
std::vector<HeldOutView> kept_views(const fs::path& folder, const json& key) {
  std::vector<HeldOutView> views;
  if (!fs::exists(folder / "views.json")) return views;
  const json kept = json::parse(read_text_file(folder / "views.json"), nullptr, false);
  if (!kept.is_object() || kept.value("key", json()) != key) return views;
  for (const json& view : kept.value("views", json::array())) {
    const size_t i = views.size();
    views.push_back({view.value("frame", ""), view.value("psnr", 0.0),
                     read_text_file(image_file(folder, i, "truth")),
                     read_text_file(image_file(folder, i, "drawn"))});
  }
  return views;
}

std::string keep(const fs::path& file, const Image8& image) {
  write_png(file, narrowed_image(image, kWidth));
  return read_text_file(file);
}

}  // namespace

std::vector<HeldOutView> held_out_views(Backend& backend, const fs::path& run, int64_t count) {
  const RunFolder files{run};
  const fs::path folder = run / "held_out";
  Fnv1a hash;
  hash.add(read_text_file(files.model()));
  const json key = {hash.hex(), count};
  std::vector<HeldOutView> views = kept_views(folder, key);
  if (!views.empty() || count == 0) return views;
  const GaussianModel model = load_model(files.model());
  const std::string path = files.scene();
  if (path.empty() || !fs::exists(path))
    throw InputError(fmt::format("{}: its scene '{}' is gone, so that no view of it can be drawn",
                                 run.string(), path));
  const SceneLock in_use(path, SceneLock::Use::kRead);
  const Scene scene = scaled_scene(scene_for(model, path, {.held_out = count}), model.train_scale);
  make_folder(folder);
  json list = json::array();
  Renderer renderer(backend, model);
  for (const Frame& frame : scene.frames) {
    const RenderedImage image = renderer.render({{frame.camera, frame.time}}).front();
    const Image8 drawn = quantise(image.planar(), image.width, image.height);
    const size_t i = views.size();
    views.push_back({frame.name, psnr(drawn, frame.image),
                     keep(image_file(folder, i, "truth"), frame.image),
                     keep(image_file(folder, i, "drawn"), drawn)});
    list.push_back({{"frame", frame.name}, {"psnr", views.back().psnr}});
  }
  write_text_file(folder / "views.json", json{{"key", key}, {"views", list}}.dump(1));
  return views;
}

}  // namespace tessera
