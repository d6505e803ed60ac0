// Slopes of pixels by time are central differences of renderings.
#include "recon4d/evaluation/clock_fit.h"

#include <algorithm>
#include <cmath>

#include "recon4d/evaluation/metrics.h"
#include "recon4d/model/clocks.h"

namespace tessera {
namespace {

constexpr int kRounds = 3;
constexpr size_t kMostFrames = 32;  // of a camera, evenly
constexpr double kReach = 0.25;     // frames to either side of a slope

/// Normal equation of an offset.
struct OffsetEquation {
  double squares = 0, product = 0;  // Σ slope², Σ slope · (truth − drawn)

  void add(const Frame& frame, const RenderedImage& now, const RenderedImage& before,
           const RenderedImage& after, double distance) {
    const Span<const uint8_t> mask = used_mask(frame);
    const auto pixels = int64_t(now.alpha.size());
    for (int64_t p = 0; p < pixels; ++p)
      for (int64_t c = 0; c < 3 && is_used(mask, size_t(p)); ++c) {
        const auto i = size_t(c * pixels + p);
        const double slope = double(after.rgb[i] - before.rgb[i]) / distance;
        squares += slope * slope;
        product += slope * (frame.image.data[size_t(3 * p + c)] / 255.0 - double(now.rgb[i]));
      }
  }
};

double offset_of(Renderer& renderer, const Scene& scene, const std::vector<int>& frames) {
  const double step = frame_step(scene, frames), reach = kReach * step;
  double offset = 0;
  for (int round = 0; round < kRounds && step > 0; ++round) {
    OffsetEquation equation;
    const size_t count = std::min(frames.size(), kMostFrames);
    for (size_t k = 0; k < count; ++k) {
      const Frame& frame = scene.frames[size_t(frames[k * frames.size() / count])];
      const double time = frame.time + offset;
      const std::vector<RenderedImage> images = renderer.render(
          {{frame.camera, time}, {frame.camera, time - reach}, {frame.camera, time + reach}});
      equation.add(frame, images[0], images[1], images[2], 2 * reach);
    }
    if (equation.squares <= 0) break;
    offset = std::clamp(offset + equation.product / equation.squares, -step, step);
  }
  return offset;
}

}  // namespace

std::map<std::string, double> fit_clocks(Renderer& renderer, const Scene& scene,
                                         const std::vector<int>& frames) {
  std::map<std::string, std::vector<int>> of_camera;
  for (const int i : frames) of_camera[scene.frames[size_t(i)].camera_name].push_back(i);
  std::map<std::string, double> offsets;
  for (const auto& [camera, its] : of_camera) offsets[camera] = offset_of(renderer, scene, its);
  return offsets;
}

}  // namespace tessera
