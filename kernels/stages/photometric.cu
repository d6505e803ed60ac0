// The loss stage of the device: it copies pointers to the device, enqueues the two passes of
// photometric_kernels.cu and returns their sums. The targets of a batch and the residual are here
// as well.
#include <algorithm>

#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/cuda/photometric_tile.cuh"

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
    residual[i] = counts ? colour[i] - truth : 0.0f;
  }
}

}  // namespace

DeviceTarget CudaBackend::target_of(const std::vector<Span<const uint8_t>>& truth,
                                    const std::vector<Span<const uint8_t>>& mask,
                                    const std::vector<Vec3<double>>& response) {
  check_device(cudaEventSynchronize(target_copied_), "waiting for the last copy of pointers");
  const auto copy = [this](auto& to, const auto* from, int64_t count, const char* what) {
    to.resize(count);
    check_device(cudaMemcpyAsync(to.data(), from, sizeof(*from) * size_t(count),
                                 cudaMemcpyHostToDevice, stream_),
                 what);
  };
  DeviceTarget target;
  const bool masked = std::any_of(mask.begin(), mask.end(),
                                  [](const Span<const uint8_t>& m) { return !m.empty(); });
  const size_t truths = truth.size(), masks = masked ? mask.size() : 0;
  if (truths + masks > 0) {
    const uint8_t** const staged = truth_host_.reserve(int64_t(truths + masks));
    for (size_t b = 0; b < truths; ++b) staged[b] = truth[b].data;
    for (size_t b = 0; b < masks; ++b) staged[truths + b] = mask[b].data;
    copy(truth_, staged, int64_t(truths + masks), "copy of pointers");
    target.truth = truth_.data();
    target.mask = masked ? truth_.data() + truths : nullptr;
  }
  if (!response.empty()) {
    const int64_t count = 3 * int64_t(response.size());
    float* const staged = response_host_.reserve(count);
    for (int64_t i = 0; i < count; ++i) staged[i] = float(response[size_t(i / 3)][int(i % 3)]);
    copy(response_, staged, count, "copy of responses");
    target.response = response_.data();
  }
  check_device(cudaEventRecord(target_copied_, stream_), "cudaEventRecord");
  return target;
}

void CudaBackend::photometric(const PhotometricArgs<float>& args, Span<float> d_colour) {
  const std::vector<ViewArgs<float>>& views = args.batch->views;
  check_target(args);
  const int64_t count = int64_t(views.size());
  int width = 0, height = 0;
  for (const ViewArgs<float>& view : views) {
    width = max_of(width, view.width);
    height = max_of(height, view.height);
  }
  const DeviceTarget target = target_of(args.truth, args.mask);
  loss_sums_.resize(2 * count);
  map_sums_.resize(0);
  loss_views_ = views;
  loss_weights_ = args.weights;
  scratch_.resize(int64_t(
      photometric_scratch_bytes(args.batch->pixels, int(count), width, height, !d_colour.empty())));
  launch_photometric({views_of(*args.batch), target.truth, target.mask, int(count), width, height,
                      args.batch->pixels, args.colour.data, d_colour.data, scratch_.data(),
                      loss_sums_.data(), float(args.weights.l1), float(args.weights.dssim),
                      float(args.weights.moving), float(args.weights.c2())},
                     stream_);
  check_launch("photometric");
  report();
  const double samples = 3.0 * double(args.batch->pixels);
  clock_.add_bytes(kPhotometric, samples * (d_colour.empty() ? 5 : 5 + 12 + 12 + 5 + 4));
  if (target.mask != nullptr) clock_.add_bytes(kPhotometric, samples * (d_colour.empty() ? 1 : 2));
}

void CudaBackend::residual(const PhotometricArgs<float>& args, Span<float> residual) {
  check_target(args);
  check(residual.size == 3 * args.batch->pixels, "residual: size of the images");
  if (args.batch->pixels == 0) return;
  const DeviceTarget target = target_of(args.truth, args.mask);
  write_residual<<<grid_of_views(*args.batch, kThreads), kThreads, 0, stream_>>>(
      views_of(*args.batch), target, args.colour.data, residual.data);
  check_launch("residual");
  clock_.add_bytes(kPhotometric, 3.0 * double(args.batch->pixels) * (4 + 1 + 4));
}

}  // namespace tessera
