// What: the optimizer as a stage of its own, rows gathered by index, on the device.
// Not: the fused optimizer (project_backward.cu).
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_error.h"
#include "kernels/stages/gradient_sink.h"

namespace tessera {
namespace {

constexpr int kThreads = 256;

/// Scalars of a group, rows of `width`, of which the first `head` have step sizes of their own.
__global__ void adam_group(const float* gradient, float* value, float* m, float* v, int64_t count,
                           int width, int head, AdamScalars<float> first, AdamScalars<float> rest) {
  const int64_t i = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (i < count) adam_step(i % width < head ? first : rest, gradient[i], value[i], m[i], v[i]);
}

/// T: float or float4, the widest that divides a row.
template <class T>
__global__ void gather(const T* from, Span<const int64_t> index, int width, int64_t inherited,
                       T* to) {
  const int64_t at = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  const int64_t i = at / width;
  if (i >= index.size) return;
  const int64_t row = i < inherited ? index[i] : -1;
  to[at] = row >= 0 ? from[row * width + at % width] : T{};
}

__global__ void limit(Span<float> values, float most) {
  const int64_t i = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (i < values.size) values[i] = fminf(values[i], most);
}

}  // namespace

void CudaBackend::adam(const SinkArgs<float>& args) {
  double scalars = 0;
  const auto launch = [&](const SinkArgs<float>& rows, Group group) {
    const int width = rows.value.width(group);
    const int head = group == kSh ? 3 : group == kShTime ? 0 : width;  // the rest has sh_rest
    const int64_t count = rows.value.count * width;
    if (count == 0) return;
    adam_group<<<grid_of(count, kThreads), kThreads, 0, stream_>>>(
        rows.gradient.group[group].data, rows.value.group[group].data,
        rows.moment1.group[group].data, rows.moment2.group[group].data, count, width, head,
        rows.adam.group[group], rows.adam.sh_rest);
    scalars += double(count);
  };
  const GaussianSpans<float>& set = args.value;
  for (int g = 0; g < group_count(set.dim()); ++g)
    if (g != kSh && g != kShTime) launch(args, Group(g));
  for_each_block(set.blocks, set.count, set.coefficients, [&](const ShBlock& block) {
    const SinkArgs<float> rows = args.block(block);
    launch(rows, kSh);
    if (set.dim() == 4) launch(rows, kShTime);
  });
  check_launch("adam");
  clock_.add_bytes(kUpdate, 28 * scalars);
}

void CudaBackend::gather_rows(Span<const float> from, Span<const int64_t> index, int width,
                              int64_t inherited, Span<float> to) {
  check(to.size == index.size * width, "gather_rows: target size");
  if (to.empty()) return;
  if (width % 4 == 0)
    gather<<<grid_of(to.size / 4, kThreads), kThreads, 0, stream_>>>(
        reinterpret_cast<const float4*>(from.data), index, width / 4, inherited,
        reinterpret_cast<float4*>(to.data));
  else
    gather<<<grid_of(to.size, kThreads), kThreads, 0, stream_>>>(from.data, index, width, inherited,
                                                                 to.data);
  check_launch("gather_rows");
  clock_.add_bytes(kDensity, 8.0 * double(to.size));
}

void CudaBackend::limit_values(Span<float> values, float most) {
  if (values.empty()) return;
  limit<<<grid_of(values.size, kThreads), kThreads, 0, stream_>>>(values, most);
  check_launch("limit_values");
}

void CudaBackend::fill_zero(Span<float> values) {
  if (!values.empty())
    check_device(cudaMemsetAsync(values.data, 0, size_t(values.size) * sizeof(float), stream_),
                 "fill_zero");
}

}  // namespace tessera
