// Calls of the stages of a step in their order.
#include "kernels/pipeline.h"

#include <utility>

#include "kernels/base/errors.h"

namespace tessera {

template <class Real>
const Images<Real>& Pipeline<Real>::forward(const ForwardArgs<Real>& args) {
  batch_ = make_view_batch<Real>(args.views);
  project_ = {&batch_, {args.sets[0], args.sets[1]}, args.options, args.for_backward};
  environment_ = args.environment;
  environment_.batch = &batch_;
  StageClock& clock = backend_.clock();
  {
    const StageTimer timer(clock, kProject);
    if (GaussianSpans<const Real>& canonical = project_.sets[0];
        canonical.form == SetForm::kCanonical) {
      backend_.carry({&batch_, canonical, args.nodes}, carried_);
      canonical.carried = std::as_const(carried_).gaussians.data();
      canonical.carried_stride = canonical.count;
      nodes_ = args.nodes;
    }
    backend_.project(project_, splats_);
  }
  {
    const StageTimer timer(clock, kBin);
    backend_.bin({&batch_, &splats_, args.options, args.for_backward}, instances_);
  }
  const StageTimer timer(clock, kBlend);
  backend_.blend(blend_args(), images_);
  if (!environment_.map.empty()) backend_.environment(environment_, images_);
  return images_;
}

template <class Real>
PhotometricArgs<Real> Pipeline<Real>::compared(const Target& target) {
  Span<const Real> colour = std::as_const(images_).colour.span();
  if (!target.maps.empty()) {
    mapped_.resize(colour.size);
    backend_.map_colours({&batch_, target.maps, colour}, mapped_.span());
    colour = std::as_const(mapped_).span();
  }
  return {&batch_, colour, target.truth, target.weights, target.mask};
}

template <class Real>
void Pipeline<Real>::loss(const Target& target, bool for_backward) {
  d_colour_.resize(for_backward ? 3 * batch_.pixels : 0);
  const StageTimer timer(backend_.clock(), kPhotometric);
  backend_.photometric(compared(target), d_colour_.span());
  if (for_backward && !target.maps.empty())
    backend_.map_colours_backward({&batch_, target.maps, std::as_const(images_).colour.span()},
                                  d_colour_.span());
}

template <class Real>
void Pipeline<Real>::backward(const BackwardArgs<Real>& args) {
  check(d_colour_.size() == 3 * batch_.pixels, "backward without a gradient of the images");
  check(project_.for_backward, "backward after a forward pass that was not for it");
  d_splats_.resize(splats_.count);
  const bool lengths = args.statistics[0].length_share > 0 || args.statistics[1].length_share > 0;
  lengths_.resize(lengths ? splats_.count : 0);
  {
    const StageTimer timer(backend_.clock(), kBlendBackward);
    if (!environment_.map.empty())
      backend_.environment_backward(environment_, images_, d_colour_.span(), args.d_environment);
    backend_.blend_backward({blend_args(), &images_, d_colour_.span(), lengths_.span()},
                            d_splats_.span());
  }
  const GaussianSpans<const Real>& canonical = project_.sets[0];
  const bool carries = canonical.form == SetForm::kCanonical;
  d_carried_.resize(carries ? int64_t(batch_.views.size()) * canonical.count : 0);
  ProjectBackwardArgs<Real> project;
  project.forward = project_;
  project.splats = &splats_;
  project.d_splats = d_splats_.span();
  project.lengths = std::as_const(lengths_).span();
  project.regulariser = args.regulariser;
  project.d_carried = d_carried_.span();
  project.by_time = args.by_time;
  for (int set = 0; set < 2; ++set) {
    project.sinks[set] = args.sinks[set];
    project.statistics[set] = args.statistics[set];
  }
  const StageTimer timer(backend_.clock(), kProjectBackward);
  backend_.project_backward(project);
  if (carries)
    backend_.carry_backward({{&batch_, canonical, nodes_},
                             &carried_,
                             std::as_const(d_carried_).span(),
                             args.sinks[0],
                             args.d_nodes,
                             args.acceleration});
}

template <class Real>
void Pipeline<Real>::residual(const Target& target) {
  d_colour_.resize(3 * batch_.pixels);
  const StageTimer timer(backend_.clock(), kPhotometric);
  backend_.residual(compared(target), d_colour_.span());
  compared_ = target;
}

template <class Real>
Span<const SplatSensitivity<Real>> Pipeline<Real>::sensitivity() {
  check(d_colour_.size() == 3 * batch_.pixels, "sensitivity without an image");
  check(project_.for_backward, "sensitivity after a forward pass that was not for it");
  sensitivity_.resize(splats_.count);
  std::vector<Vec3<double>> response;
  for (const ColourMap<double>& map : compared_.maps) response.push_back(channel_response(map));
  const StageTimer timer(backend_.clock(), kBlendBackward);
  backend_.sensitivity({{blend_args(), &images_, d_colour_.span()}, compared_.mask, response},
                       sensitivity_.span());
  return sensitivity_.span();
}

template <class Real>
void Pipeline<Real>::add_contributions(Span<ElementSums<Real>> elements,
                                       Span<TimeVariation> variation) {
  const StageTimer timer(backend_.clock(), kProjectBackward);
  backend_.contributions(
      {project_, &splats_, std::as_const(sensitivity_).span(), elements, variation});
}

template <class Real>
void Pipeline<Real>::add_largest_weights(Span<Real> elements) {
  check(project_.for_backward, "largest weights after a forward pass that was not for them");
  const StageTimer timer(backend_.clock(), kBlendBackward);
  backend_.largest_weights(blend_args(), images_, elements);
}

template <class Real>
void Pipeline<Real>::release() {
  Memory& memory = backend_.memory();
  splats_ = Splats<Real>(memory);
  instances_ = TileInstances<Real>(memory);
  images_ = Images<Real>(memory);
  mapped_.release();
  d_colour_.release();
  d_splats_.release();
  lengths_.release();
  carried_ = Carried<Real>(memory);
  d_carried_.release();
  sensitivity_.release();
}

template class Pipeline<float>;
template class Pipeline<double>;

}  // namespace tessera
