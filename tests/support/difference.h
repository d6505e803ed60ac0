// The loss of a TestScene as a function of its parameters, in double, with its central differences.
// Steps that cross a cut-off are detected and shortened.
#pragma once
#include <optional>

#include "tests/support/render.h"

namespace tessera::testing {

/// Loss, and a digest of every decision that makes the loss discontinuous or kinked: which splats
/// exist, which pixels each covers, where a pixel stops, clamped channels, the sign of I − G.
struct ProbedLoss {
  double loss = 0;
  uint64_t decisions = 0;
};

class LossProbe {
 public:
  explicit LossProbe(const TestScene<double>& scene) : target_(target_of(scene)) {}

  ProbedLoss at(const TestScene<double>& scene) {
    const StoredScene<double> in(scene, backend_.memory());
    const Images<double>& images = pipeline_.forward(in.forward(false));
    ProbedLoss out;
    target_.maps = scene.maps;
    pipeline_.loss(target_);
    for (const ViewLoss& loss : pipeline_.outcome().losses)
      out.loss += loss.total / double(scene.views.size());
    digest_ = 0xcbf29ce484222325u;
    for (const int32_t used : images.used) add(uint64_t(used));
    add_splats(scene.options);
    add_signs(images);
    out.decisions = digest_;
    return out;
  }

 private:
  void add(uint64_t value) { digest_ = (digest_ ^ value) * 0x100000001b3u; }

  void add_splats(const RenderOptions& options) {
    const Cutoff<double> cutoff = make_cutoff<double>(options);
    const Splats<double>& splats = pipeline_.splats();
    for (const int64_t first : splats.first_of) add(uint64_t(first));
    for (const Splat<double>& splat : splats.splat) {
      add(uint64_t(splat.view) << 8 | splat.negative);
      const ViewArgs<double>& view = pipeline_.batch().views[size_t(splat.view)];
      for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x) {
          const double falloff =
              splat_falloff(splat.conic, splat.mean2d[0] - x - 0.5, splat.mean2d[1] - y - 0.5);
          add(cutoff.draws(splat.opacity * falloff, falloff));
        }
    }
  }

  void add_signs(const Images<double>& images) {
    for (size_t b = 0; b < target_.truth.size(); ++b) {
      const ViewArgs<double>& view = pipeline_.batch().views[b];
      const int64_t pixels = int64_t(view.width) * view.height;
      const ColourMap<double> map = target_.maps.empty() ? ColourMap<double>() : target_.maps[b];
      const double* const colour = images.colour.data() + 3 * view.first_pixel;
      for (int64_t p = 0; p < pixels; ++p) {
        const Vec3<double> x = map({colour[p], colour[pixels + p], colour[2 * pixels + p]});
        for (int c = 0; c < 3; ++c) add(x[c] > target_.truth[b][3 * p + c] / 255.0);
      }
    }
  }

  CpuBackend<double> backend_;
  Pipeline<double> pipeline_{backend_};
  Target target_;
  uint64_t digest_ = 0;
};

/// dL/d `parameter` (a scalar inside `scene`) by Richardson-extrapolated central differences:
/// (4·D(h/2) − D(h))/3, error of order h⁴. Empty when even the shortest step crosses a cut-off.
inline std::optional<double> difference(LossProbe& probe, TestScene<double>& scene,
                                        double& parameter, uint64_t decisions) {
  const double x = parameter;
  for (double step = 4e-4; step > 4e-6; step /= 3) {
    double D[2];
    bool smooth = true;
    for (int half = 0; half < 2 && smooth; ++half) {
      const double h = half == 0 ? step : step / 2;
      parameter = x + h;
      const ProbedLoss above = probe.at(scene);
      parameter = x - h;
      const ProbedLoss below = probe.at(scene);
      parameter = x;
      smooth = above.decisions == decisions && below.decisions == decisions;
      D[half] = (above.loss - below.loss) / (2 * h);
    }
    if (smooth) return (4 * D[1] - D[0]) / 3;
  }
  return std::nullopt;
}

}  // namespace tessera::testing
