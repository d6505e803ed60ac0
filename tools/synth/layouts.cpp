// The dnerf layout (transforms files and PNG images) and the multi-camera layouts (one mp4 a
// camera, for n3dv with LLFF's poses_bounds.npy).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/png.h"
#include "ingest/poses/llff_poses.h"
#include "kernels/base/parallel.h"
#include "tools/synth/ground_truth.h"
#include "tools/synth/layouts.h"
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
               world_time(job.options, frame + shift_of(job.options, number)))) {
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
    times.push_back(world_time(job.options, frame + shift_of(job.options, number)));
  return ever_covered(job.world, camera, times, layer);
}

/// Renders, encodes and masks every instant of one camera, and fills in its boxes.
void film(const CaptureJob& job, int number, TrueView& view, const StaticLayer& layer) {
  const SynthOptions& options = job.options;
  VideoEncoder encoder(job.folder / (view.name + ".mp4"),
                       {options.width, options.height, options.fps, options.video_quality});
  Camera camera = view.camera;
  const double readout = readout_of(options, number);
  camera.readout = std::copysign(world_time(options, readout), readout);
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
      const RenderedImage image = render(job.world, camera, world_time(options, instant), layer);
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
