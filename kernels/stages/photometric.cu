// What: the loss stage of the device: pointers in, two passes enqueued, sums on their way back;
// what a batch is compared with, for this stage and others. Not: the kernels
// (photometric_kernels.cu).
#include <algorithm>

#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_error.h"
#include "kernels/cuda/photometric_kernels.h"
#include "kernels/stages/target_check.h"

namespace tessera {

DeviceTarget CudaBackend::target_of(const std::vector<Span<const uint8_t>>& truth,
                                    const std::vector<Span<const uint8_t>>& mask,
                                    const std::vector<Vec3<double>>& gain) {
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
  if (!gain.empty()) {
    const int64_t count = 3 * int64_t(gain.size());
    float* const staged = gain_host_.reserve(count);
    for (int64_t i = 0; i < count; ++i) staged[i] = float(gain[size_t(i / 3)][int(i % 3)]);
    copy(gain_, staged, count, "copy of gains");
    target.gain = gain_.data();
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
  const DeviceTarget target = target_of(args.truth, args.mask, args.gain);
  const bool d_gain = !args.gain.empty() && !d_colour.empty();
  loss_sums_.resize(d_gain ? 5 * count : 2 * count);
  loss_views_ = views;
  loss_weights_ = args.weights;
  scratch_.resize(int64_t(
      photometric_scratch_bytes(args.batch->pixels, int(count), width, height, !d_colour.empty())));
  launch_photometric(
      {views_of(*args.batch), target.truth, target.mask, int(count), width, height,
       args.batch->pixels, args.images->colour.data(), d_colour.data, scratch_.data(),
       loss_sums_.data(), float(args.weights.l1), float(args.weights.dssim),
       float(args.weights.moving), target.gain, loss_sums_.data() + 2 * count},
      stream_);
  check_launch("photometric");
  report();
  const double samples = 3.0 * double(args.batch->pixels);
  clock_.add_bytes(kPhotometric, samples * (d_colour.empty() ? 5 : 5 + 12 + 12 + 5 + 4));
  if (target.mask != nullptr) clock_.add_bytes(kPhotometric, samples * (d_colour.empty() ? 1 : 2));
}

}  // namespace tessera
