// What: the multi-camera layouts: one mp4 a camera, for n3dv with LLFF's poses_bounds.npy.
// Not: the encoder (video_encoder.h).
// Source of the pose format: method.md E.2 (LLFF).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/files/npy.h"
#include "ingest/files/png.h"
#include "kernels/base/parallel.h"
#include "tools/synth/layouts.h"
#include "tools/synth/render.h"
#include "tools/synth/rigs.h"
#include "tools/synth/sensor.h"
#include "tools/synth/video_encoder.h"

namespace tessera::synth {
namespace {

constexpr int kFramesAtOnce = 8;  // held in memory while their masks are written side by side

/// Depths (camera z) between which everything seen at any instant lies, with a margin.
struct DepthRange {
  double near = 1e300, far = 0;
};

DepthRange depth_range(const CaptureJob& job, const Camera& camera, const StaticLayer& layer) {
  DepthRange range;
  for (const float depth : layer.depth) {
    if (std::isinf(depth)) continue;
    range.near = std::min(range.near, double(depth));
    range.far = std::max(range.far, double(depth));
  }
  for (int frame = 0; frame < job.options.frames; ++frame)
    for (const PlacedSolid& mover :
         place(job.world, Part::kMoving, normalised_time(job.options, frame))) {
      const double z = (camera.cam_from_world * mover.origin + camera.translation).z;
      range.near = std::min(range.near, z - mover.radius);
      range.far = std::max(range.far, z + mover.radius);
    }
  return {std::max(0.05, 0.95 * range.near), 1.05 * range.far};
}

/// One row of poses_bounds.npy: 3 × 5 row-major [down, right, backward, position, (h, w, f)], then
/// near and far.
void fill_llff_row(Matrix& rows, int64_t row, const Camera& camera, const DepthRange& range) {
  const auto pose = opengl_pose(camera);
  const double size[] = {double(camera.height), double(camera.width), camera.fl_x};
  for (int64_t i = 0; i < 3; ++i) {
    const auto& line = pose[size_t(i)];
    const double values[] = {-line[1], line[0], line[2], line[3], size[i]};
    for (int64_t k = 0; k < 5; ++k) rows(row, 5 * i + k) = values[k];
  }
  rows(row, 15) = range.near, rows(row, 16) = range.far;
}

/// Renders, encodes and masks every instant of one camera.
void film(const CaptureJob& job, int number, const TrueView& view, const StaticLayer& layer) {
  const SynthOptions& options = job.options;
  VideoEncoder encoder(job.folder / (view.name + ".mp4"),
                       {options.width, options.height, options.fps, options.video_quality});
  for (int first = 0; first < options.frames; first += kFramesAtOnce) {
    if (job.progress)
      job.progress(view.name, int64_t(number) * options.frames + first,
                   int64_t(options.cameras) * options.frames);
    std::vector<Image8> masks;
    for (int frame = first; frame < std::min(first + kFramesAtOnce, options.frames); ++frame) {
      const Picture picture =
          render(job.world, view.camera, normalised_time(options, frame), layer);
      encoder.add(expose(picture, options, 3, number, frame));
      masks.push_back(mask_image(picture));
    }
    parallel_for(int64_t(masks.size()), 1, [&](int64_t begin, int64_t end) {
      for (int64_t i = begin; i < end; ++i)
        write_png(
            job.folder / kTruthFolder / fmt::format("mask_{}_{:04}.png", view.name, first + i),
            masks[size_t(i)]);
    });
  }
  encoder.finish();
}

}  // namespace

std::vector<TrueView> write_videos(const CaptureJob& job) {
  const std::vector<Camera> cameras = video_rig(job.options, job.world.target);
  Matrix poses{int64_t(cameras.size()), 17, std::vector<double>(17 * cameras.size())};
  std::vector<TrueView> views;
  for (int number = 0; number < job.options.cameras; ++number) {
    views.push_back({fmt::format("cam{:02}", number), cameras[size_t(number)], "", 0, 0});
    const TrueView& view = views.back();
    const StaticLayer layer = render_static(job.world, view.camera, job.options.supersampling);
    fill_llff_row(poses, number, view.camera, depth_range(job, view.camera, layer));
    film(job, number, view, layer);
  }
  if (job.options.layout == SynthLayout::kN3dv) write_npy(job.folder / "poses_bounds.npy", poses);
  const int64_t total = int64_t(job.options.cameras) * job.options.frames;
  if (job.progress) job.progress("videos", total, total);
  return views;
}

}  // namespace tessera::synth
