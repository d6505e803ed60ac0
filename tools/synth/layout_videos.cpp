// What: the multi-camera layouts: one mp4 a camera, for n3dv with LLFF's poses_bounds.npy.
// Not: the encoder (video_encoder.h).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/files/atomic_file.h"
#include "ingest/files/png.h"
#include "ingest/poses/llff_poses.h"
#include "kernels/base/parallel.h"
#include "tools/synth/layouts.h"
#include "tools/synth/moving_masks.h"
#include "tools/synth/render.h"
#include "tools/synth/rigs.h"
#include "tools/synth/sensor.h"
#include "tools/video/video_encoder.h"

namespace tessera::synth {
namespace {

constexpr int kFramesAtOnce = 8;  // held in memory while their masks are written side by side

/// Near and far depth (camera z) between which everything seen at any instant lies, with a margin.
LlffPose bounded_pose(const CaptureJob& job, int number, const Camera& camera,
                      const StaticLayer& layer) {
  LlffPose pose{camera, 1e300, 0};
  for (const float depth : layer.depth) {
    if (std::isinf(depth)) continue;
    pose.near = std::min(pose.near, double(depth));
    pose.far = std::max(pose.far, double(depth));
  }
  for (int frame = 0; frame < job.options.frames; ++frame)
    for (const PlacedSolid& mover :
         place(job.world, Part::kMoving,
               normalised_time(job.options, frame + shift_of(job.options, number)))) {
      const double z = (camera.cam_from_world * mover.origin + camera.translation).z;
      pose.near = std::min(pose.near, z - mover.radius);
      pose.far = std::max(pose.far, z + mover.radius);
    }
  pose.near = std::max(0.05, 0.95 * pose.near);
  pose.far *= 1.05;
  return pose;
}

/// Where something ever moves in that camera; empty for scenes without a stated moving region.
std::vector<uint8_t> moving_region(const CaptureJob& job, int number, const Camera& camera,
                                   const StaticLayer& layer) {
  if (!has_moving_region(job.options)) return {};
  std::vector<double> times;
  for (int frame = 0; frame < job.options.frames; ++frame)
    times.push_back(normalised_time(job.options, frame + shift_of(job.options, number)));
  return ever_covered(job.world, camera, times, layer);
}

/// Renders, encodes and masks every instant of one camera, and fills in its boxes.
void film(const CaptureJob& job, int number, TrueView& view, const StaticLayer& layer) {
  const SynthOptions& options = job.options;
  VideoEncoder encoder(job.folder / (view.name + ".mp4"),
                       {options.width, options.height, options.fps, options.video_quality});
  const std::vector<uint8_t> region = moving_region(job, number, view.camera, layer);
  for (const Solid& solid : job.world.solids)
    if (solid.moves) view.boxes[solid.name].resize(size_t(options.frames));
  if (!region.empty()) make_folder(job.folder / kMovingFolder / view.name);
  for (int first = 0; first < options.frames; first += kFramesAtOnce) {
    if (job.progress)
      job.progress(view.name, int64_t(number) * options.frames + first,
                   int64_t(options.cameras) * options.frames);
    std::vector<Image8> masks, moving;
    for (int frame = first; frame < std::min(first + kFramesAtOnce, options.frames); ++frame) {
      const double instant = frame + shift_of(options, number);
      const RenderedImage image =
          render(job.world, view.camera, normalised_time(options, instant), layer);
      encoder.add(expose(image, options, 3, number, frame));
      masks.push_back(mask_image(image));
      for (const auto& [name, box] : image.boxes) view.boxes[name][size_t(frame)] = box;
      if (!region.empty()) moving.push_back(moving_image(image, region));
    }
    parallel_for(int64_t(masks.size()), 1, [&](int64_t begin, int64_t end) {
      for (int64_t i = begin; i < end; ++i) {
        write_png(
            job.folder / kTruthFolder / fmt::format("mask_{}_{:04}.png", view.name, first + i),
            masks[size_t(i)]);
        if (!moving.empty())
          write_png(job.folder / kMovingFolder / view.name / fmt::format("{:05}.png", first + i),
                    moving[size_t(i)]);
      }
    });
  }
  encoder.finish();
}

}  // namespace

std::vector<TrueView> write_videos(const CaptureJob& job) {
  const std::vector<Camera> cameras = video_rig(job.options, job.world.target);
  std::vector<LlffPose> poses;
  std::vector<TrueView> views;
  for (int number = 0; number < job.options.cameras; ++number) {
    views.push_back({fmt::format("cam{:02}", number), cameras[size_t(number)], "", 0, 0});
    TrueView& view = views.back();
    const StaticLayer layer = render_static(job.world, view.camera, job.options.supersampling);
    poses.push_back(bounded_pose(job, number, view.camera, layer));
    film(job, number, view, layer);
  }
  if (job.options.layout == SynthLayout::kN3dv)
    write_llff_poses(job.folder / "poses_bounds.npy", poses);
  const int64_t total = int64_t(job.options.cameras) * job.options.frames;
  if (job.progress) job.progress("videos", total, total);
  return views;
}

}  // namespace tessera::synth
