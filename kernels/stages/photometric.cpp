// The loss (1−λ)·L1 + λ·(1 − SSIM) of each view and its gradient on the CPU, one colour plane at a
// time, and the residual of every image. The truth of pixels that a mask ignores is the rendered
// value. The loss is taken on the image as rendered, without a clamp  [method 0.8]. Source: method
// A.15.
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/stages/ssim_window.h"

namespace tessera {
namespace {

/// Sums of one colour plane of one view.
struct PlaneLoss {
  double l1 = 0, ssim = 0;
};

/// One colour plane as rendered, and what it is compared with.
template <class Real>
struct Plane {
  const Real* colour;    // [H·W]
  const uint8_t* truth;  // sample of pixel p at 3·p
  const uint8_t* mask;   // [H·W] or null
  int width, height;
};

template <class Real>
struct PlaneScratch {
  std::vector<Real> truth, by_x, by_xx, by_xy, convolved;
};

/// Writes dL/d plane; `scale` = 1 / (3·H·W·B).
template <class Real>
PlaneLoss plane_loss(const Plane<Real>& plane, const LossWeights& weights, Real scale, Real* d_x,
                     PlaneScratch<Real>& s) {
  const int width = plane.width, height = plane.height;
  const uint8_t* const mask = plane.mask;
  const size_t pixels = size_t(width) * size_t(height);
  const Real* const x = plane.colour;
  const auto ignored = [mask](size_t p) { return mask != nullptr && mask[p] == 0; };
  const auto l1_factor = [&](size_t p) {
    return mask != nullptr && mask[p] == kMovingPixel ? weights.moving : 1.0;
  };
  for (std::vector<Real>* map : {&s.truth, &s.by_x, &s.by_xx, &s.by_xy, &s.convolved})
    map->resize(pixels);
  for (size_t p = 0; p < pixels; ++p)
    s.truth[p] = ignored(p) ? x[p] : Real(plane.truth[3 * p]) / Real(255);
  const Real* y = s.truth.data();
  PlaneLoss loss;
  const Real lambda = Real(-weights.dssim) * scale;
  const auto read = [&](int row, Real* a, Real* b) {
    std::copy_n(x + int64_t(row) * width, width, a);
    std::copy_n(y + int64_t(row) * width, width, b);
  };
  MomentRows<Real>(width, height, Padding::kZero).compute(read, [&](int row, const auto& moments) {
    for (int column = 0; column < width; ++column) {
      const size_t p = size_t(row) * size_t(width) + size_t(column);
      if (ignored(p)) {
        loss.ssim += 1;
        s.by_x[p] = s.by_xx[p] = s.by_xy[p] = Real(0);
        continue;
      }
      const SsimPoint<Real> point = ssim_point<Real>(moments(column), Real(weights.c2()));
      loss.l1 += l1_factor(p) * double(std::abs(x[p] - y[p]));
      loss.ssim += double(point.value);
      s.by_x[p] = lambda * point.d_x;
      s.by_xx[p] = lambda * point.d_xx;
      s.by_xy[p] = lambda * point.d_xy;
    }
  });
  if (d_x == nullptr) return loss;
  for (std::vector<Real>* map : {&s.by_x, &s.by_xx, &s.by_xy})
    convolve(map->data(), width, height, Padding::kZero, s.convolved.data(), map->data());
  const Real l1 = Real(weights.l1) * scale;
  for (size_t p = 0; p < pixels; ++p) {
    const Real d = photometric_gradient(l1 * Real(l1_factor(p)), x[p], y[p], s.by_x[p], s.by_xx[p],
                                        s.by_xy[p]);
    d_x[p] = ignored(p) ? Real(0) : d;
  }
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
    const Plane<Real> plane{args.colour.data + start, args.truth[b].data + channel,
                            args.mask.empty() ? nullptr : args.mask[b].data, view.width,
                            view.height};
    planes[size_t(task)] = plane_loss(plane, args.weights, scale,
                                      d_colour.empty() ? nullptr : d_colour.data + start, scratch);
  });
  std::vector<ViewLoss>& losses = outcome_.losses;
  losses.assign(views.size(), {});
  outcome_.d_maps.clear();
  for (size_t b = 0; b < views.size(); ++b) {
    const double samples = 3.0 * views[b].width * views[b].height;
    double l1 = 0, ssim = 0;
    for (size_t c = 0; c < 3; ++c) {
      l1 += planes[3 * b + c].l1;
      ssim += planes[3 * b + c].ssim;
    }
    losses[b] = view_loss(args.weights, l1, ssim, samples);
  }
}

template <class Real>
void CpuBackend<Real>::residual(const PhotometricArgs<Real>& args, Span<Real> residual) {
  const std::vector<ViewArgs<Real>>& views = args.batch->views;
  check_target(args);
  check(residual.size == 3 * args.batch->pixels, "residual: size of the images");
  parallel_for(3 * int64_t(views.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t plane = begin; plane < end; ++plane) {
      const size_t b = size_t(plane / 3);
      const int channel = int(plane % 3);
      const int64_t pixels = int64_t(views[b].width) * views[b].height;
      const int64_t start = 3 * views[b].first_pixel + channel * pixels;
      const uint8_t* const mask = args.mask.empty() ? nullptr : args.mask[b].data;
      const uint8_t* const truth = args.truth[b].data + channel;
      for (int64_t p = 0; p < pixels; ++p)
        residual[start + p] = mask != nullptr && mask[p] == 0
                                  ? Real(0)
                                  : args.colour[start + p] - Real(truth[3 * p]) / Real(255);
    }
  });
}

template void CpuBackend<float>::photometric(const PhotometricArgs<float>&, Span<float>);
template void CpuBackend<double>::photometric(const PhotometricArgs<double>&, Span<double>);
template void CpuBackend<float>::residual(const PhotometricArgs<float>&, Span<float>);
template void CpuBackend<double>::residual(const PhotometricArgs<double>&, Span<double>);

}  // namespace tessera
