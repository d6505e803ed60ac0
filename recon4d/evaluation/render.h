// Images of a model with its own background, clip planes and SH degree, and the rate of images per
// second of one view at a time after warm-up. Source: failure mode D8.
#pragma once
#include <optional>
#include <vector>

#include "kernels/pipeline.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// As rendered: not clamped, not quantised (metrics.h does that).
struct RenderedImage {
  int width = 0, height = 0;
  std::vector<float> rgb;    // [3, height, width] background included
  std::vector<float> alpha;  // [height, width] 1 − transmittance

  Span<const float> planar() const { return {rgb.data(), int64_t(rgb.size())}; }
};

/// The drawing rules of a model.
RenderOptions render_options(const GaussianModel& model);
/// Its environment for a forward pass; the map lies where the model's does, or at `map`.
EnvironmentArgs<float> environment_of(const GaussianModel& model, Span<const float> map = {});

/// Keeps the buffers of a pipeline between calls. Backend and model must outlive it. A set that is
/// not in the backend's memory is brought there once.
class Renderer {
 public:
  Renderer(Backend& backend, const GaussianModel& model);

  /// One image per view, all through the kernels as one batch.
  std::vector<RenderedImage> render(const std::vector<View>& views);
  /// The same into `to`, [views], whose memory is used again.
  void render(const std::vector<View>& views, Span<RenderedImage> to);
  /// The same without taking the images out: for timing.
  const Images<float>& draw(const std::vector<View>& views);
  /// To be called when the model's values have changed.
  void refresh();
  /// Of the last call: splats, instances, Gaussians that are none.
  PipelineReport report() const { return pipeline_.report(); }
  /// To be changed between calls.
  RenderOptions& options() { return options_; }
  /// From the next call on the Gaussians alone, without background or environment.
  void draw_no_background();

 private:
  /// Set k where the backend can read it.
  const GaussianSet& set(int k) const;

  Backend& backend_;
  const GaussianModel& model_;
  RenderOptions options_;
  Pipeline<float> pipeline_;
  std::optional<GaussianSet> copies_[2];
  std::optional<MotionNodes> nodes_;  // where the model's are in another memory
  Buffer<float> environment_;         // the same
  bool background_ = true;
};

/// For a single call.
std::vector<RenderedImage> render_views(Backend& backend, const GaussianModel& model,
                                        const std::vector<View>& views);

struct RenderRateOptions {
  int64_t frames = 300;  // to be timed
  double seconds = 20;   // fewer where they do not fit in this time; at least one
  int64_t warm_up = 10;  // rendered before
};

struct RenderRate {
  int64_t frames = 0;         // that were timed
  double seconds = 0;         // they took: the device's events, or the host's clock
  double wall_seconds = 0;    // the same with launches and waits between them
  int width = 0, height = 0;  // of the first view
  int64_t num_gaussians = 0;

  double fps() const { return seconds > 0 ? double(frames) / seconds : 0; }
};

/// Views in turn, at least one.
RenderRate measure_render_rate(Backend& backend, const GaussianModel& model,
                               const std::vector<View>& views,
                               const RenderRateOptions& options = {});

}  // namespace tessera
