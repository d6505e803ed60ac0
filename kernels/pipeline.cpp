// What: the stages of a step in their order.
// Not: any arithmetic.
#include "kernels/pipeline.h"

#include <chrono>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Adds the time until its end to a stage.
class StageTimer {
 public:
  StageTimer(std::array<double, kStages>& seconds, Stage stage)
      : total_(seconds[size_t(stage)]), begin_(std::chrono::steady_clock::now()) {}
  ~StageTimer() {
    total_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  double& total_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace

template <class Real>
const Images<Real>& Pipeline<Real>::forward(const GaussianSpans<const Real>& static_set,
                                            const GaussianSpans<const Real>& dynamic_set,
                                            const std::vector<View>& views,
                                            const RenderOptions& options, bool for_backward) {
  batch_ = make_view_batch<Real>(views);
  project_ = {&batch_, {static_set, dynamic_set}, options};
  {
    const StageTimer timer(stage_seconds_, kProject);
    backend_.project(project_, splats_);
  }
  {
    const StageTimer timer(stage_seconds_, kBin);
    backend_.bin(batch_, splats_, for_backward, instances_);
  }
  const StageTimer timer(stage_seconds_, kBlend);
  backend_.blend({&batch_, &splats_, &instances_, options}, images_);
  return images_;
}

template <class Real>
std::vector<ViewLoss> Pipeline<Real>::loss(const Target& target, bool for_backward) {
  d_colour_.resize(for_backward ? 3 * batch_.pixels : 0);
  const StageTimer timer(stage_seconds_, kPhotometric);
  return backend_.photometric({&batch_, &images_, target.truth, target.weights}, d_colour_.span());
}

template <class Real>
unsigned Pipeline<Real>::backward(const BackwardArgs<Real>& args) {
  check(d_colour_.size() == 3 * batch_.pixels, "backward without a gradient of the pictures");
  d_splats_.resize(splats_.count);
  const BlendArgs<Real> blend{&batch_, &splats_, &instances_, project_.options};
  {
    const StageTimer timer(stage_seconds_, kBlendBackward);
    backend_.blend_backward({blend, &images_, d_colour_.span()}, d_splats_.span());
  }
  ProjectBackwardArgs<Real> project{project_, &splats_, d_splats_.span(), {}, {}};
  for (int set = 0; set < 2; ++set) {
    project.sinks[set] = args.sinks[set];
    project.statistics[set] = args.statistics[set];
  }
  const StageTimer timer(stage_seconds_, kProjectBackward);
  return backend_.project_backward(project);
}

template class Pipeline<float>;
template class Pipeline<double>;

}  // namespace tessera
