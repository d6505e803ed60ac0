// Conversion of the cameras, times and drawing rules of a batch to the form that kernels read.
#include "kernels/batch.h"

#include <string>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Tiles of a view are numbered in 32 bits, and in 16 bits along each side (TileRect).
void check_size(const Camera& camera) {
  constexpr int64_t kMostAlong = int64_t{UINT16_MAX} * kTileSize;
  constexpr int64_t kMostPixels = int64_t{INT32_MAX} * kTileSize * kTileSize;
  const int64_t width = camera.width, height = camera.height;
  if (width <= kMostAlong && height <= kMostAlong &&
      (width + kTileSize) * (height + kTileSize) <= kMostPixels)
    return;
  throw InputError("a view of " + std::to_string(width) + " by " + std::to_string(height) +
                   " pixels is too large: at most " + std::to_string(kMostAlong) +
                   " along a side and " + std::to_string(kMostPixels) +
                   " in all are supported; use a smaller size");
}

}  // namespace

template <class Real>
ViewBatch<Real> make_view_batch(const std::vector<View>& views) {
  ViewBatch<Real> batch;
  for (const View& view : views) {
    const Camera& c = view.camera;
    check_size(c);
    ViewArgs<Real> v;
    v.fl_x = Real(c.fl_x);
    v.fl_y = Real(c.fl_y);
    v.cx = Real(c.cx);
    v.cy = Real(c.cy);
    v.cam_from_world = Mat3<Real>(c.cam_from_world);
    v.translation = Vec3<Real>(c.translation);
    v.position = Vec3<Real>(c.position());
    v.time = Real(view.time);
    v.readout = Real(c.readout);
    v.timestep = view.timestep;
    v.series = view.series;
    v.width = c.width;
    v.height = c.height;
    v.tiles_x = (c.width + kTileSize - 1) / kTileSize;
    v.tiles_y = (c.height + kTileSize - 1) / kTileSize;
    v.first_tile = batch.tiles;
    v.first_pixel = batch.pixels;
    batch.tiles += int64_t(v.tiles_x) * v.tiles_y;
    batch.pixels += int64_t(c.width) * c.height;
    batch.views.push_back(v);
  }
  return batch;
}

template <class Real>
SplatRules<Real> make_splat_rules(const RenderOptions& options) {
  return {Real(options.near_plane),
          Real(options.far_plane),
          options.filter_2d ? kFilter2d<Real> : kDilation<Real>,
          Real(options.time_filter),
          options.filter_2d,
          make_cutoff<Real>(options),
          options.kernels.bounds};
}

template <class Real>
ColourRules<Real> make_colour_rules(const RenderOptions& options, int coefficients,
                                    int time_levels) {
  return {min_of(options.sh_degree, sh_degree_of(coefficients)),
          min_of(options.sh_time_degree, time_levels), 3 * coefficients,
          Real(options.sh_time_period), options.sliced_direction};
}

template ColourRules<float> make_colour_rules<float>(const RenderOptions&, int, int);
template ColourRules<double> make_colour_rules<double>(const RenderOptions&, int, int);
template SplatRules<float> make_splat_rules<float>(const RenderOptions&);
template SplatRules<double> make_splat_rules<double>(const RenderOptions&);
template ViewBatch<float> make_view_batch<float>(const std::vector<View>&);
template ViewBatch<double> make_view_batch<double>(const std::vector<View>&);

}  // namespace tessera
