// What: make_capture: a temporary folder is filled and then takes the place of `out`.
// Not: what is written into it (layout_*.cpp, ground_truth.cpp).
#include "tools/synth/synth.h"

#include <system_error>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "kernels/base/errors.h"
#include "tools/synth/ground_truth.h"
#include "tools/synth/layouts.h"
#include "tools/synth/world.h"

namespace tessera {

bool is_made_capture(const std::filesystem::path& folder) {
  std::error_code ignored;  // a folder that cannot be read is refused by StagedFolder
  return std::filesystem::exists(folder / synth::kTruthFile, ignored);
}

SynthReport make_capture(const SynthOptions& options, const std::filesystem::path& out,
                         const SynthProgress& progress) {
  const SynthOptions full = resolve_synth_options(options);
  if (out.empty()) throw InputError("synth: the output has no name; name a folder");
  const synth::World world =
      synth::build_world(full.scene, full.seed, full.specular,
                         full.scene == SynthScene::kPatch ? synth::patch_radius(full) : 0);
  StagedFolder pending(out, is_made_capture(out));
  make_folder(pending.path() / synth::kTruthFolder);

  const bool dnerf = full.layout == SynthLayout::kDnerf;
  const synth::CaptureJob job{full, world, pending.path(), progress};
  const std::vector<synth::TrueView> views =
      dnerf ? synth::write_dnerf(job) : synth::write_videos(job);

  const PointCloud points = synth::sample_static_points(world, views, full.points, full.seed);
  synth::write_points(pending.path() / synth::kTruthFolder / "points.ply", points);
  write_text_file(pending.path() / synth::kTruthFile, synth::truth_json(full, world, views));
  pending.commit();

  SynthReport report;
  report.cameras = dnerf ? 1 : full.cameras;
  report.images = dnerf ? int64_t(views.size()) : int64_t(full.cameras) * full.frames;
  report.points = int64_t(points.position.size());
  return report;
}

}  // namespace tessera
