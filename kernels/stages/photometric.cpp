// What: (1−λ)·L1 + λ·(1 − SSIM) of each view and its gradient, one colour plane at a time.
//       Pixels that a mask ignores have none: their truth is what was rendered.
// Not: a clamp: the loss is taken on the picture as rendered  [method 0.8].
// Source: method A.15.
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/stages/ssim_window.h"

namespace tessera {
namespace {

/// Sums of one colour plane of one view.
struct PlaneLoss {
  double l1 = 0, ssim = 0;
};

template <class Real>
struct PlaneScratch {
  std::vector<Real> truth, by_x, by_xx, by_xy;
  MomentPlanes<Real> moments;
};

/// Writes dL/dx for x = rendered plane; `scale` = 1 / (3·H·W·B); `mask` [H·W] or null.
template <class Real>
PlaneLoss plane_loss(const Real* x, const uint8_t* truth_rgb, const uint8_t* mask, int width,
                     int height, const LossWeights& weights, Real scale, Real* d_x,
                     PlaneScratch<Real>& s) {
  const size_t pixels = size_t(width) * size_t(height);
  const auto ignored = [mask](size_t p) { return mask != nullptr && mask[p] == 0; };
  for (std::vector<Real>* plane : {&s.truth, &s.by_x, &s.by_xx, &s.by_xy}) plane->resize(pixels);
  for (size_t p = 0; p < pixels; ++p)
    s.truth[p] = ignored(p) ? x[p] : Real(truth_rgb[3 * p]) / Real(255);
  const Real* y = s.truth.data();
  s.moments.compute(x, y, width, height, Padding::kZero);
  PlaneLoss loss;
  const Real lambda = Real(-weights.dssim) * scale;
  for (size_t p = 0; p < pixels; ++p) {
    if (ignored(p)) {
      loss.ssim += 1;
      s.by_x[p] = s.by_xx[p] = s.by_xy[p] = Real(0);
      continue;
    }
    const SsimPoint<Real> point = s.moments.point(p);
    loss.l1 += double(std::abs(x[p] - y[p]));
    loss.ssim += double(point.value);
    s.by_x[p] = lambda * point.d_x;
    s.by_xx[p] = lambda * point.d_xx;
    s.by_xy[p] = lambda * point.d_xy;
  }
  if (d_x == nullptr) return loss;
  for (std::vector<Real>* plane : {&s.by_x, &s.by_xx, &s.by_xy})
    convolve(plane->data(), width, height, Padding::kZero, s.moments.scratch.data(), plane->data());
  const Real l1 = Real(weights.l1) * scale;
  for (size_t p = 0; p < pixels; ++p) {
    const Real sign = x[p] > y[p] ? Real(1) : (x[p] < y[p] ? Real(-1) : Real(0));
    const Real d = l1 * sign + s.by_x[p] + Real(2) * x[p] * s.by_xx[p] + y[p] * s.by_xy[p];
    d_x[p] = ignored(p) ? Real(0) : d;
  }
  return loss;
}

}  // namespace

template <class Real>
void CpuBackend<Real>::photometric(const PhotometricArgs<Real>& args, Span<Real> d_colour) {
  const std::vector<ViewArgs<Real>>& views = args.batch->views;
  check(args.truth.size() == views.size(), "photometric: one ground truth per view");
  check(args.mask.empty() || args.mask.size() == views.size(), "photometric: one mask per view");
  std::vector<PlaneLoss> planes(3 * views.size());
  parallel_for(int64_t(planes.size()), 1, [&](int64_t task, int64_t) {
    thread_local PlaneScratch<Real> scratch;
    const ViewArgs<Real>& view = views[size_t(task / 3)];
    const int64_t pixels = int64_t(view.width) * view.height;
    const int64_t start = 3 * view.first_pixel + task % 3 * pixels;
    const Real scale = Real(1.0 / (3.0 * double(pixels) * double(views.size())));
    planes[size_t(task)] = plane_loss(
        args.images->colour.data() + start, args.truth[size_t(task / 3)].data + task % 3,
        args.mask.empty() ? nullptr : args.mask[size_t(task / 3)].data, view.width, view.height,
        args.weights, scale, d_colour.empty() ? nullptr : d_colour.data + start, scratch);
  });
  std::vector<ViewLoss>& losses = outcome_.losses;
  losses.assign(views.size(), {});
  for (size_t b = 0; b < views.size(); ++b) {
    const double samples = 3.0 * views[b].width * views[b].height;
    for (size_t c = 0; c < 3; ++c) {
      losses[b].l1 += planes[3 * b + c].l1 / samples;
      losses[b].ssim += planes[3 * b + c].ssim / samples;
    }
    losses[b].total = args.weights.l1 * losses[b].l1 + args.weights.dssim * (1 - losses[b].ssim);
  }
}

template void CpuBackend<float>::photometric(const PhotometricArgs<float>&, Span<float>);
template void CpuBackend<double>::photometric(const PhotometricArgs<double>&, Span<double>);

}  // namespace tessera
