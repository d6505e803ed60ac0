// The optimizer as a separate stage and elements gathered by index, on the device. The fused
// optimizer is in project_backward.cu.
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/stages/gradient_sink.h"

namespace tessera {
namespace {

constexpr int kThreads = 256;

__global__ void adam_group(const float* gradient, float* value, float* m, float* v, int64_t count,
                           AdamScalars<float> adam) {
  const int64_t i = linear_index();
  if (i < count) adam_step(adam, gradient[i], value[i], m[i], v[i]);
}

/// Of SH, elements of `width`, of which the first `head` have step sizes of their own.
__global__ void adam_sh(const float* gradient, float* value, float* moments, int64_t count,
                        int width, int head, AdamScalars<float> first, AdamScalars<float> rest) {
  const int64_t i = linear_index();
  if (i < count)
    adam_step_packed(i % width < head ? first : rest, gradient[i], value[i], moments[i]);
}

/// T: float or float4, the widest that divides an element.
template <class T>
__global__ void gather(const T* from, Span<const int64_t> index, int width, int64_t inherited,
                       T* to) {
  const int64_t scalar = linear_index();
  const int64_t i = scalar / width;
  if (i >= index.size) return;
  const int64_t element = i < inherited ? index[i] : -1;
  to[scalar] = element >= 0 ? from[element * width + scalar % width] : T{};
}

__global__ void approach(Span<const float> values, float weight, Span<float> mean) {
  const int64_t i = linear_index();
  if (i < values.size) mean[i] += weight * (values[i] - mean[i]);
}

__global__ void limit(Span<float> values, float most) {
  const int64_t i = linear_index();
  if (i < values.size) values[i] = fminf(values[i], most);
}

}  // namespace

void CudaBackend::adam(const SinkArgs<float>& args) {
  double bytes = 0;
  const GaussianSpans<float>& set = args.value;
  for (int g = 0; g < group_count(set.form); ++g) {
    if (moment_buffers(Group(g)) != 2) continue;
    const int64_t count = set.count * set.width(Group(g));
    launch_linear<kThreads>(stream_, "adam: adam_group", adam_group, count,
                            args.gradient.group[g].data, args.value.group[g].data,
                            args.moment1.group[g].data, args.moment2.group[g].data, count,
                            args.adam.group[g]);
    bytes += 28.0 * double(count);
  }
  for_each_block(set.blocks, set.count, set.coefficients, [&](const ShBlock& block) {
    const SinkArgs<float> elements = args.block(block);
    for (const Group group : {kSh, kShTime}) {
      const int width = elements.value.width(group);
      const int64_t count = block.count * width;
      launch_linear<kThreads>(stream_, "adam: adam_sh", adam_sh, count,
                              elements.gradient.group[group].data, elements.value.group[group].data,
                              elements.moment1.group[group].data, count, width,
                              group == kSh ? 3 : 0, args.adam.group[kSh], args.adam.sh_rest);
      bytes += 20.0 * double(count);
    }
  });
  clock_.add_bytes(kUpdate, bytes);
}

void CudaBackend::gather_elements(Span<const float> from, Span<const int64_t> index, int width,
                                  int64_t inherited, Span<float> to) {
  check(to.size == index.size * width, "gather_elements: target size");
  if (to.empty()) return;
  if (width % 4 == 0)
    launch_linear<kThreads>(stream_, "gather_elements: gather", gather<float4>, to.size / 4,
                            reinterpret_cast<const float4*>(from.data), index, width / 4, inherited,
                            reinterpret_cast<float4*>(to.data));
  else
    launch_linear<kThreads>(stream_, "gather_elements: gather", gather<float>, to.size, from.data,
                            index, width, inherited, to.data);
  clock_.add_bytes(kDensity, 8.0 * double(to.size));
}

void CudaBackend::add_to_mean(Span<const float> values, float weight, Span<float> mean) {
  if (values.empty()) return;
  launch_linear<kThreads>(stream_, "add_to_mean: approach", approach, values.size, values, weight,
                          mean);
}

void CudaBackend::limit_values(Span<float> values, float most) {
  if (values.empty()) return;
  launch_linear<kThreads>(stream_, "limit_values: limit", limit, values.size, values, most);
}

void CudaBackend::fill_zero(Span<float> values) {
  if (!values.empty())
    check_device(cudaMemsetAsync(values.data, 0, size_t(values.size) * sizeof(float), stream_),
                 "fill_zero");
}

}  // namespace tessera
