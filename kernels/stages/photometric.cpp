// What: (1−λ)·L1 + λ·(1 − SSIM) of each view and its gradient, one colour plane at a time.
//       Pixels that a mask ignores have none: their truth is what was rendered. A view's gain is
//       applied here, and its gradient summed.
// Not: a clamp: the loss is taken on the image as rendered  [method 0.8].
// Source: method A.15.
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/math/gain.h"
#include "kernels/stages/ssim_window.h"
#include "kernels/stages/target_check.h"

namespace tessera {
namespace {

/// Sums of one colour plane of one view.
struct PlaneLoss {
  double l1 = 0, ssim = 0, d_gain = 0;
};

/// One colour plane as rendered, and what it is compared with.
template <class Real>
struct Plane {
  const Real* colour;    // [H·W]
  const uint8_t* truth;  // sample of pixel p at 3·p
  const uint8_t* mask;   // [H·W] or null
  int width, height;
  const double* gain;  // null: none
};

template <class Real>
struct PlaneScratch {
  std::vector<Real> gained, truth, by_x, by_xx, by_xy;
  MomentPlanes<Real> moments;
};

/// The plane times its gain.
template <class Real>
const Real* compared(const Plane<Real>& plane, size_t pixels, PlaneScratch<Real>& s) {
  if (plane.gain == nullptr) return plane.colour;
  s.gained.resize(pixels);
  for (size_t p = 0; p < pixels; ++p) s.gained[p] = Real(*plane.gain) * plane.colour[p];
  return s.gained.data();
}

/// dL/dx becomes dL/d plane; returns dL/d gain.
template <class Real>
double through_gain(const Plane<Real>& plane, size_t pixels, Real* d_x) {
  double d_gain = 0;
  for (size_t p = 0; p < pixels; ++p) {
    const GainGradient<Real> d = gain_backward(Real(*plane.gain), plane.colour[p], d_x[p]);
    d_x[p] = d.colour;
    d_gain += double(d.gain);
  }
  return d_gain;
}

/// Writes dL/d plane; `scale` = 1 / (3·H·W·B).
template <class Real>
PlaneLoss plane_loss(const Plane<Real>& plane, const LossWeights& weights, Real scale, Real* d_x,
                     PlaneScratch<Real>& s) {
  const int width = plane.width, height = plane.height;
  const uint8_t* const mask = plane.mask;
  const size_t pixels = size_t(width) * size_t(height);
  const Real* const x = compared(plane, pixels, s);
  const auto ignored = [mask](size_t p) { return mask != nullptr && mask[p] == 0; };
  const auto l1_factor = [&](size_t p) {
    return mask != nullptr && mask[p] == kMovingPixel ? weights.moving : 1.0;
  };
  for (std::vector<Real>* map : {&s.truth, &s.by_x, &s.by_xx, &s.by_xy}) map->resize(pixels);
  for (size_t p = 0; p < pixels; ++p)
    s.truth[p] = ignored(p) ? x[p] : Real(plane.truth[3 * p]) / Real(255);
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
    loss.l1 += l1_factor(p) * double(std::abs(x[p] - y[p]));
    loss.ssim += double(point.value);
    s.by_x[p] = lambda * point.d_x;
    s.by_xx[p] = lambda * point.d_xx;
    s.by_xy[p] = lambda * point.d_xy;
  }
  if (d_x == nullptr) return loss;
  for (std::vector<Real>* map : {&s.by_x, &s.by_xx, &s.by_xy})
    convolve(map->data(), width, height, Padding::kZero, s.moments.scratch.data(), map->data());
  const Real l1 = Real(weights.l1) * scale;
  for (size_t p = 0; p < pixels; ++p) {
    const Real d = photometric_gradient(l1 * Real(l1_factor(p)), x[p], y[p], s.by_x[p], s.by_xx[p],
                                        s.by_xy[p]);
    d_x[p] = ignored(p) ? Real(0) : d;
  }
  if (plane.gain != nullptr) loss.d_gain = through_gain(plane, pixels, d_x);
  return loss;
}

}  // namespace

template <class Real>
void CpuBackend<Real>::photometric(const PhotometricArgs<Real>& args, Span<Real> d_colour) {
  const std::vector<ViewArgs<Real>>& views = args.batch->views;
  check_target(args);
  std::vector<PlaneLoss> planes(3 * views.size());
  parallel_for(int64_t(planes.size()), 1, [&](int64_t task, int64_t) {
    thread_local PlaneScratch<Real> scratch;
    const size_t b = size_t(task / 3);
    const int channel = int(task % 3);
    const ViewArgs<Real>& view = views[b];
    const int64_t pixels = int64_t(view.width) * view.height;
    const int64_t start = 3 * view.first_pixel + channel * pixels;
    const Real scale = Real(1.0 / (3.0 * double(pixels) * double(views.size())));
    const Plane<Real> plane{args.images->colour.data() + start,
                            args.truth[b].data + channel,
                            args.mask.empty() ? nullptr : args.mask[b].data,
                            view.width,
                            view.height,
                            args.gain.empty() ? nullptr : &args.gain[b][channel]};
    planes[size_t(task)] = plane_loss(plane, args.weights, scale,
                                      d_colour.empty() ? nullptr : d_colour.data + start, scratch);
  });
  std::vector<ViewLoss>& losses = outcome_.losses;
  losses.assign(views.size(), {});
  outcome_.d_gain.assign(d_colour.empty() ? 0 : args.gain.size(), Vec3<double>(0));
  for (size_t b = 0; b < views.size(); ++b) {
    const double samples = 3.0 * views[b].width * views[b].height;
    double l1 = 0, ssim = 0;
    for (size_t c = 0; c < 3; ++c) {
      l1 += planes[3 * b + c].l1;
      ssim += planes[3 * b + c].ssim;
      if (!outcome_.d_gain.empty()) outcome_.d_gain[b][int(c)] = planes[3 * b + c].d_gain;
    }
    losses[b] = view_loss(args.weights, l1, ssim, samples);
  }
}

template void CpuBackend<float>::photometric(const PhotometricArgs<float>&, Span<float>);
template void CpuBackend<double>::photometric(const PhotometricArgs<double>&, Span<double>);

}  // namespace tessera
