// What: by how much every image misses its ground truth.
// Not: a loss (photometric.cpp). Not a clamp: the image is taken as rendered.
// Source: method A.15; failure modes B10 (gains), B17 (masks).
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/math/gain.h"
#include "kernels/stages/target_check.h"

namespace tessera {

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
      const Real gain = args.gain.empty() ? Real(1) : Real(args.gain[b][channel]);
      for (int64_t p = 0; p < pixels; ++p)
        residual[start + p] = mask != nullptr && mask[p] == 0
                                  ? Real(0)
                                  : gained_residual(gain, args.images->colour[start + p],
                                                    Real(truth[3 * p]) / Real(255));
    }
  });
}

template void CpuBackend<float>::residual(const PhotometricArgs<float>&, Span<float>);
template void CpuBackend<double>::residual(const PhotometricArgs<double>&, Span<double>);

}  // namespace tessera
