// One call that renders a TestScene on any backend and one that also computes gradients, both by
// kernels/pipeline.h. The default backend is the CPU's.
#pragma once
#include <functional>
#include <limits>

#include "kernels/cpu_backend.h"
#include "tests/support/stored_scene.h"

namespace tessera::testing {

/// A copy of what a forward pass made.
template <class Real>
struct Rendered {
  std::vector<Real> colour, transmittance;  // laid out as Images
  std::vector<int32_t> used;
  PipelineReport report;
};

template <class Real>
Rendered<Real> copy_of(const Images<Real>& images, const PipelineReport& report,
                       Memory& memory = host_memory()) {
  return {fetched(images.colour, memory), fetched(images.transmittance, memory),
          fetched(images.used, memory), report};
}

template <class Real>
Rendered<Real> render(const TestScene<Real>& scene, BackendOf<Real>& backend) {
  const StoredScene<Real> in(scene, backend.memory());
  Pipeline<Real> pipeline(backend);
  const Images<Real>& images = pipeline.forward(in.forward(false));
  return copy_of(images, pipeline.report(), backend.memory());
}

template <class Real>
Rendered<Real> render(const TestScene<Real>& scene) {
  CpuBackend<Real> backend;
  return render(scene, backend);
}

/// A ground truth that keeps 8 to 60 steps away from the image, its colours mapped where the scene
/// has maps, so that no |I − G| sits on its kink.
inline void keep_truth_away(TestScene<double>& scene, uint64_t seed) {
  const Rendered<double> image = render(scene);
  Random random(seed);
  const double* colour = image.colour.data();
  for (size_t b = 0; b < scene.truth.size(); ++b) {
    std::vector<uint8_t>& bytes = scene.truth[b];
    const ColourMap<double> map = scene.maps.empty() ? ColourMap<double>() : scene.maps[b];
    const size_t pixels = bytes.size() / 3;
    for (size_t i = 0; i < bytes.size(); ++i) {
      const double* const red = colour + i / 3;
      const double x = 255 * map({red[0], red[pixels], red[2 * pixels]})[int(i % 3)];
      const double away = random.uniform(8, 60);
      const bool up = x + away <= 255 && (random.below(2) == 1 || x - away < 0);
      bytes[i] = uint8_t(std::clamp(up ? x + away : x - away, 0.0, 255.0));
    }
    colour += bytes.size();
  }
}

/// The ground truth where it lies, on the host.
template <class Real>
Target target_of(const TestScene<Real>& scene) {
  Target target;
  for (const auto& bytes : scene.truth)
    target.truth.emplace_back(bytes.data(), int64_t(bytes.size()));
  for (const auto& bytes : scene.mask)
    target.mask.emplace_back(bytes.data(), int64_t(bytes.size()));
  target.weights = scene.weights;
  target.maps = scene.maps;
  return target;
}

template <class Real>
struct Backward {
  TestGaussians<Real> fixed, moving;  // gradients
  std::vector<Real> statistic[2], seen[2];
  std::vector<ViewLoss> losses;
  Rendered<Real> rendered;
  unsigned bad = 0;
  std::vector<ColourMap<double>> d_maps;
  std::vector<double> d_times, d_readouts;
  std::vector<Real> d_environment;
  TestNodes<Real> d_nodes;

  double mean_loss() const {
    double sum = 0;
    for (const ViewLoss& loss : losses) sum += loss.total;
    return sum / double(losses.size());
  }
};

/// Changes dL/d image before it goes backward.
template <class Real>
using EditImageGradient = std::function<void(std::vector<Real>&)>;

/// Forward, loss and backward with stored gradients.
template <class Real>
Backward<Real> backward(const TestScene<Real>& scene, BackendOf<Real>& backend,
                        const EditImageGradient<Real>& edit = {}) {
  Memory& memory = backend.memory();
  const StoredScene<Real> in(scene, memory);
  Pipeline<Real> pipeline(backend);
  Backward<Real> out;
  const Images<Real>& images = pipeline.forward(in.forward(true));
  pipeline.loss(in.target(), true);
  out.rendered = copy_of(images, pipeline.report(), memory);
  if (edit) {
    std::vector<Real> d_colour = fetched(pipeline.d_colour(), memory);
    edit(d_colour);
    store_over(d_colour, pipeline.d_colour().span(), memory);
  }
  const TestGaussians<Real>* sets[2] = {&scene.fixed, &scene.moving};
  BackwardArgs<Real> args;
  args.regulariser = scene.regulariser;
  std::vector<StoredGaussians<Real>> gradients;
  std::vector<Buffer<Real>> statistics;
  for (const TestGaussians<Real>* set : sets) {
    TestGaussians<Real> unwritten(set->form, set->count, set->coefficients, set->time_levels,
                                  set->blocks);
    for (std::vector<Real>& group : unwritten.group)
      std::fill(group.begin(), group.end(), std::numeric_limits<Real>::quiet_NaN());
    gradients.emplace_back(unwritten, memory);
    for (int k = 0; k < 2; ++k)
      statistics.push_back(stored(std::vector<Real>(size_t(set->count), Real(0)), memory));
  }
  for (size_t set = 0; set < 2; ++set) {
    args.sinks[set].gradient = gradients[set].spans();
    args.statistics[set] = {statistics[2 * set].span(), statistics[2 * set + 1].span(),
                            Real(scene.length_share)};
  }
  Buffer<Real> d_environment(int64_t(scene.environment.size()), memory);
  args.d_environment = d_environment.span();
  StoredNodes<Real> d_nodes(scene.nodes.like(), memory);
  args.d_nodes = d_nodes.spans();
  args.acceleration = Real(scene.acceleration);
  args.by_time = true;
  pipeline.backward(args);
  out.d_nodes = d_nodes.fetch();
  out.d_environment = fetched(d_environment, memory);
  const StepOutcome outcome = pipeline.outcome();
  out.losses = outcome.losses;
  out.bad = outcome.bad_groups;
  out.d_maps = outcome.d_maps;
  out.d_times = outcome.d_times;
  out.d_readouts = outcome.d_readouts;
  out.fixed = gradients[0].fetch();
  out.moving = gradients[1].fetch();
  for (size_t set = 0; set < 2; ++set) {
    out.statistic[set] = fetched(statistics[2 * set], memory);
    out.seen[set] = fetched(statistics[2 * set + 1], memory);
  }
  return out;
}

template <class Real>
Backward<Real> backward(const TestScene<Real>& scene, const EditImageGradient<Real>& edit = {}) {
  CpuBackend<Real> backend;
  return backward(scene, backend, edit);
}

}  // namespace tessera::testing
