// Writes the PLY frames and the player page of a run, in the world of its capture.
#include "tools/export/run_outputs.h"

#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "recon4d/model/model_file.h"
#include "static3d/formats/frame_sequence.h"
#include "static3d/transform/world_change.h"
#include "tools/camera_paths/camera_path.h"
#include "tools/camera_paths/export_times.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/export/clean_model.h"
#include "tools/export/formats.h"
#include "tools/export/output_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::vector<std::string> sequence_files(size_t count) {
  std::vector<std::string> files{"manifest.json"};
  for (size_t i = 0; i < count; ++i)
    files.push_back(sequence_file_name(int64_t(i), int64_t(count), splat_format("ply")));
  return files;
}

}  // namespace

json write_run_frames(const RunFolder& run, const fs::path& folder, int64_t count) {
  const GaussianModel model = model_in_source_world(load_model(run.model()));
  if (model.environment.height > 0)
    warn("the environment is not in the PLY frames, which are 3DGS files; the model keeps it");
  const std::vector<double> times = export_times({.frames = count}, {}, true);
  OutputFolder output(folder, "run", sequence_files(times.size()), true);
  ProgressBar bar("export");
  const SequenceReport report = export_sequence(model, output.staging(), times, splat_format("ply"),
                                                [&](int64_t done, int64_t total) {
                                                  stop_if_interrupted();
                                                  bar.update(done, total);
                                                });
  output.finish();
  return {{"folder", folder.string()}, {"frames", report.frames.size()}, {"bytes", report.bytes}};
}

json write_run_player(const RunFolder& run, const fs::path& folder, const std::string& title,
                      const std::string& description) {
  constexpr int64_t kMostInside = int64_t{64} << 20;  // bytes
  GaussianModel model = load_model(run.model());
  ExportRequest page;
  page.model = run.root.string();
  page.out = folder.string();
  page.overwrite = true;
  page.format = "html";
  page.title = title;
  page.description = description;
  if (!scene_of_model(page.model).empty()) {
    page.poster = "auto";
    page.truth = true;
  }
  const json floaters = clean_if_asked(page, model);
  model = model_in_source_world(model);
  json written = find_time_format(page.format)->write(page, model);
  if (written["scene_bytes"] > kMostInside) {
    page.format = "page";
    written = find_time_format(page.format)->write(page, model);
  }
  written["folder"] = folder.string();
  written["format"] = page.format;
  written["floaters"] = floaters;
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
