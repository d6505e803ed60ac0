// What: one call that renders a TestScene on the CPU backend, one that also goes backward.
// Not: a second pipeline: both run kernels/pipeline.h.
#pragma once
#include <functional>

#include "kernels/cpu_backend.h"
#include "kernels/pipeline.h"
#include "tests/support/test_scene.h"

namespace tessera::testing {

/// A copy of what a forward pass made.
template <class Real>
struct Rendered {
  std::vector<Real> colour, transmittance;  // laid out as Images
  std::vector<int32_t> used;
  PipelineReport report;
};

template <class Real>
Rendered<Real> copy_of(const Images<Real>& images, const PipelineReport& report) {
  return {{images.colour.begin(), images.colour.end()},
          {images.transmittance.begin(), images.transmittance.end()},
          {images.used.begin(), images.used.end()},
          report};
}

template <class Real>
Rendered<Real> render(const TestScene<Real>& scene) {
  CpuBackend<Real> backend;
  Pipeline<Real> pipeline(backend);
  const Images<Real>& images =
      pipeline.forward(scene.fixed.view(), scene.moving.view(), scene.views, scene.options);
  return copy_of(images, pipeline.report());
}

template <class Real>
Target target_of(const TestScene<Real>& scene) {
  Target target;
  for (const auto& bytes : scene.truth)
    target.truth.emplace_back(bytes.data(), int64_t(bytes.size()));
  return target;
}

template <class Real>
struct Backward {
  TestGaussians<Real> fixed, moving;  // gradients
  std::vector<Real> statistic[2], seen[2];
  std::vector<ViewLoss> losses;
  Rendered<Real> rendered;
  unsigned bad = 0;

  double mean_loss() const {
    double sum = 0;
    for (const ViewLoss& loss : losses) sum += loss.total;
    return sum / double(losses.size());
  }
};

/// Forward, loss and backward with stored gradients. `edit` may change dL/d picture before it goes
/// backward.
template <class Real>
Backward<Real> backward(const TestScene<Real>& scene,
                        const std::function<void(Buffer<Real>&)>& edit = {}) {
  CpuBackend<Real> backend;
  Pipeline<Real> pipeline(backend);
  const Images<Real>& images =
      pipeline.forward(scene.fixed.view(), scene.moving.view(), scene.views, scene.options, true);
  Backward<Real> out;
  out.losses = pipeline.loss(target_of(scene), true);
  out.rendered = copy_of(images, pipeline.report());
  if (edit) edit(pipeline.d_colour());
  out.fixed = TestGaussians<Real>(scene.fixed.dim, scene.fixed.count, scene.fixed.coefficients);
  out.moving = TestGaussians<Real>(scene.moving.dim, scene.moving.count, scene.moving.coefficients);
  BackwardArgs<Real> args;
  TestGaussians<Real>* gradients[2] = {&out.fixed, &out.moving};
  for (int set = 0; set < 2; ++set) {
    const int64_t count = gradients[set]->count;
    args.sinks[set].gradient = gradients[set]->spans();
    out.statistic[set].assign(size_t(count), Real(0));
    out.seen[set].assign(size_t(count), Real(0));
    args.statistics[set] = {{out.statistic[set].data(), count}, {out.seen[set].data(), count}};
  }
  out.bad = pipeline.backward(args);
  return out;
}

}  // namespace tessera::testing
