// What: the loss stage of the device: pointers in, two passes enqueued, sums on their way back.
// Not: the kernels (photometric_kernels.cu).
#include <algorithm>

#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_error.h"
#include "kernels/cuda/photometric_kernels.h"

namespace tessera {

const float* CudaBackend::gains_of(const PhotometricArgs<float>& args) {
  if (args.gain.empty()) return nullptr;
  const int64_t count = 3 * int64_t(args.gain.size());
  float* const staged = gain_host_.reserve(count);
  for (int64_t i = 0; i < count; ++i) staged[i] = float(args.gain[size_t(i / 3)][int(i % 3)]);
  gain_.resize(count);
  check_device(cudaMemcpyAsync(gain_.data(), staged, sizeof(float) * size_t(count),
                               cudaMemcpyHostToDevice, stream_),
               "copy of gains");
  return gain_.data();
}

void CudaBackend::photometric(const PhotometricArgs<float>& args, Span<float> d_colour) {
  const std::vector<ViewArgs<float>>& views = args.batch->views;
  check_target(args);
  const int64_t count = int64_t(views.size());
  const bool masked = std::any_of(args.mask.begin(), args.mask.end(),
                                  [](const Span<const uint8_t>& mask) { return !mask.empty(); });
  const int64_t pointers = masked ? 2 * count : count;
  const uint8_t** staged = truth_host_.reserve(pointers);
  int width = 0, height = 0;
  for (size_t b = 0; b < views.size(); ++b) {
    staged[b] = args.truth[b].data;
    if (masked) staged[size_t(count) + b] = args.mask[b].data;
    width = max_of(width, views[b].width), height = max_of(height, views[b].height);
  }
  truth_.resize(pointers);
  check_device(cudaMemcpyAsync(truth_.data(), staged, sizeof(uint8_t*) * size_t(pointers),
                               cudaMemcpyHostToDevice, stream_),
               "copy of pointers");
  const bool d_gain = !args.gain.empty() && !d_colour.empty();
  loss_sums_.resize(d_gain ? 5 * count : 2 * count);
  loss_views_ = views, loss_weights_ = args.weights;
  scratch_.resize(int64_t(
      photometric_scratch_bytes(args.batch->pixels, int(count), width, height, !d_colour.empty())));
  launch_photometric(
      {views_of(*args.batch), truth_.data(), masked ? truth_.data() + count : nullptr, int(count),
       width, height, args.batch->pixels, args.images->colour.data(), d_colour.data,
       scratch_.data(), loss_sums_.data(), float(args.weights.l1), float(args.weights.dssim),
       gains_of(args), loss_sums_.data() + 2 * count},
      stream_);
  check_launch("photometric");
  report();
  const double samples = 3.0 * double(args.batch->pixels);
  clock_.add_bytes(kPhotometric, samples * (d_colour.empty() ? 5 : 5 + 12 + 12 + 5 + 4));
  if (masked) clock_.add_bytes(kPhotometric, samples * (d_colour.empty() ? 1 : 2));
}

}  // namespace tessera
