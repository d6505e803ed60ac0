// What: the monocular layout of D-NeRF and NeRF-synthetic: three splits of RGBA PNGs with poses.
// Not: video; every image has its own pose and time.
#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/png.h"
#include "tools/synth/layouts.h"
#include "tools/synth/moving_masks.h"
#include "tools/synth/render.h"
#include "tools/synth/rigs.h"
#include "tools/synth/sensor.h"

namespace tessera::synth {
namespace {

using nlohmann::ordered_json;

struct SplitPlan {
  const char* name;
  PoseSet set;
  int count;
};

/// Training views are the clip's instants; held-out ones fall between them, at the middles of
/// `count` equal parts of the clip.
std::vector<TrueView> plan_views(const CaptureJob& job, const SplitPlan& plan) {
  const std::vector<Camera> cameras =
      monocular_poses(job.options, job.world.target, plan.set, plan.count);
  std::vector<TrueView> views;
  for (int i = 0; i < plan.count; ++i) {
    const double time = plan.set == PoseSet::kTrain ? normalised_time(job.options, i)
                        : job.options.frames > 1    ? (i + 0.5) / plan.count
                                                    : 0;
    views.push_back(
        {fmt::format("{}/r_{:03}", plan.name, i), cameras[size_t(i)], plan.name, i, time});
  }
  return views;
}

void write_transforms(const CaptureJob& job, const char* split,
                      const std::vector<TrueView>& views) {
  ordered_json frames = ordered_json::array();
  for (const TrueView& view : views)
    frames.push_back({{"file_path", "./" + view.name},
                      {"time", view.time},
                      {"transform_matrix", opengl_pose(view.camera)},
                      {"fl_x", view.camera.fl_x},
                      {"fl_y", view.camera.fl_y},
                      {"cx", view.camera.cx},
                      {"cy", view.camera.cy},
                      {"w", view.camera.width},
                      {"h", view.camera.height}});
  const ordered_json transforms{{"camera_angle_x", field_of_view(job.options.scene)},
                                {"frames", frames}};
  write_text_file(job.folder / fmt::format("transforms_{}.json", split), transforms.dump(1) + "\n");
}

void write_image(const CaptureJob& job, PoseSet set, const TrueView& view) {
  const StaticLayer layer = render_static(job.world, view.camera, job.options.supersampling);
  const RenderedImage image = render(job.world, view.camera, view.time, layer);
  write_png(job.folder / (view.name + ".png"), expose(image, job.options, 4, int(set), view.index));
  write_png(job.folder / kTruthFolder / fmt::format("mask_{}_{:03}.png", view.split, view.index),
            mask_image(image));
  if (has_moving_region(job.options))
    write_png(
        job.folder / kMovingFolder / (view.name + ".png"),
        moving_image(image, ever_covered(job.world, view.camera, clip_times(job.options), layer)));
}

}  // namespace

std::vector<TrueView> write_dnerf(const CaptureJob& job) {
  const int held_out = job.options.held_out_frames;
  const std::array<SplitPlan, 3> plans{{{"train", PoseSet::kTrain, job.options.frames},
                                        {"val", PoseSet::kVal, held_out},
                                        {"test", PoseSet::kTest, held_out}}};
  const int64_t total = job.options.frames + 2 * held_out;
  std::vector<TrueView> all;
  for (const SplitPlan& plan : plans) {
    make_folder(job.folder / plan.name);
    if (has_moving_region(job.options)) make_folder(job.folder / kMovingFolder / plan.name);
    const std::vector<TrueView> views = plan_views(job, plan);
    for (const TrueView& view : views) {
      if (job.progress) job.progress(view.name, int64_t(all.size()), total);
      write_image(job, plan.set, view);
      all.push_back(view);
    }
    write_transforms(job, plan.name, views);
  }
  if (job.progress) job.progress("pictures", total, total);
  return all;
}

}  // namespace tessera::synth
