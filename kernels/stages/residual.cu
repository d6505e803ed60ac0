// What: by how much every image misses its ground truth, on the device: a thread a pixel.
// Not: a loss (photometric.cu).
// Source: method A.15; failure modes B10 (gains), B17 (masks).
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_error.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/cuda/photometric_tile.cuh"
#include "kernels/math/gain.h"
#include "kernels/stages/target_check.h"

namespace tessera {
namespace {

constexpr int kThreads = 256;

__global__ void __launch_bounds__(kThreads)
    write_residual(const ViewArgs<float>* views, DeviceTarget target, const float* colour,
                   float* residual) {
  const ViewArgs<float>& view = views[blockIdx.y];
  const int64_t pixels = int64_t(view.width) * view.height;
  const int64_t p = linear_index();
  if (p >= pixels) return;
  const bool counts = target.counts(blockIdx.y, p);
  for (int c = 0; c < 3; ++c) {
    const int64_t i = 3 * view.first_pixel + c * pixels + p;
    const float truth = photometric::truth_value(target.truth[blockIdx.y][3 * p + c]);
    residual[i] = counts ? gained_residual(target.gain_of(blockIdx.y, c), colour[i], truth) : 0.0f;
  }
}

}  // namespace

void CudaBackend::residual(const PhotometricArgs<float>& args, Span<float> residual) {
  check_target(args);
  check(residual.size == 3 * args.batch->pixels, "residual: size of the images");
  if (args.batch->pixels == 0) return;
  const DeviceTarget target = target_of(args.truth, args.mask, args.gain);
  write_residual<<<grid_of_views(*args.batch, kThreads), kThreads, 0, stream_>>>(
      views_of(*args.batch), target, args.images->colour.data(), residual.data);
  check_launch("residual");
  clock_.add_bytes(kPhotometric, 3.0 * double(args.batch->pixels) * (4 + 1 + 4));
}

}  // namespace tessera
