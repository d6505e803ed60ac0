// Writes the PLY frames and the player page of a run, in the world of its capture.
#include "tools/export/run_outputs.h"

#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "static3d/transform/world_change.h"
#include "tools/camera_paths/camera_path.h"
#include "tools/cli/terminal.h"
#include "tools/export/clean_model.h"
#include "tools/export/formats.h"
#include "tools/session/model_scene.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Of the run, replacing what an earlier one has left in the folder.
ExportRequest request_of(const RunFolder& run, const fs::path& folder, const char* format) {
  ExportRequest request;
  request.model = run.root.string();
  request.out = folder.string();
  request.format = format;
  request.overwrite = true;
  return request;
}

void to_source_world(Clip& clip) {
  clip.edit([](GaussianModel& model) { model = model_in_source_world(model); });
}

}  // namespace

json write_run_frames(const RunFolder& run, const fs::path& folder, int64_t count) {
  ExportRequest request = request_of(run, folder, "ply");
  request.times.frames = count;
  Clip clip = load_clip(run.root);
  to_source_world(clip);
  if (clip.head->environment.height > 0)
    warn("the environment is not in the PLY frames, which are 3DGS files; the model keeps it");
  const json written = export_frames(request, clip);
  return {{"folder", request.out}, {"frames", written["frames"]}, {"bytes", written["bytes"]}};
}

json write_run_player(const RunFolder& run, const fs::path& folder, const std::string& title,
                      const std::string& description) {
  constexpr int64_t kMostInside = int64_t{64} << 20;  // bytes
  Clip clip = load_clip(run.root);
  ExportRequest page = request_of(run, folder, clip.count() > 1 ? "page" : "html");
  page.title = title;
  page.description = description;
  if (!scene_of_model(page.model).empty()) {
    page.poster = "auto";
    page.truth = true;
  }
  const json floaters = clean_if_asked(page, clip);
  to_source_world(clip);
  json written = find_time_format(page.format)->write(page, clip);
  if (page.format == "html" && written["scene_bytes"] > kMostInside) {
    page.format = "page";
    written = find_time_format(page.format)->write(page, clip);
  }
  written.update({{"folder", page.out}, {"format", page.format}, {"floaters", floaters}});
  return written;
}

std::string camera_path_of(const Scene& scene) {
  std::vector<Camera> rig;
  for (int i : scene.split_indices(Split::kTrain)) rig.push_back(scene.frames[size_t(i)].camera);
  try {
    if (!rig.empty() && looks_one_way(rig, orbit_of_rig(rig, scene.points).up)) return "spiral";
  } catch (const InputError&) {  // all cameras stand on one axis, which makes no circle
  }
  return "orbit";
}

}  // namespace tessera
