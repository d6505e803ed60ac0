// The optimizer as a separate stage and elements gathered by index, on the CPU. The fused optimizer
// is the ApplyAdam sink of project_backward.
#include <algorithm>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/stages/gradient_sink.h"

namespace tessera {
namespace {

constexpr int64_t kGrain = 1024;  // Gaussians or elements per task

template <class Real>
void adam_run(const SinkArgs<Real>& args, int64_t begin, int64_t end) {
  const ApplyAdam<Real> sink{args.value, args.moment1, args.moment2, args.adam};
  const GaussianSpans<Real>& set = args.gradient;
  for (int g = 0; g < group_count(set.form); ++g) {
    const auto group = Group(g);
    const int width = set.width(group);
    if (moment_buffers(group) == 0) continue;
    for (int64_t i = begin * width; i < end * width; ++i) {
      const Real gradient = set.group[g][i];
      if (packs_moments(group))
        sink.accept_sh(group, i / width, int(i % width), gradient);
      else
        adam_step(args.adam.group[g], gradient, args.value.group[g][i], args.moment1.group[g][i],
                  args.moment2.group[g][i]);
    }
  }
}

}  // namespace

template <class Real>
void CpuBackend<Real>::adam(const SinkArgs<Real>& args) {
  const GaussianSpans<Real>& set = args.value;
  for_each_block(set.blocks, set.count, set.coefficients, [&](const ShBlock& block) {
    const SinkArgs<Real> elements = args.block(block);
    parallel_for(block.count, kGrain,
                 [&](int64_t begin, int64_t end) { adam_run(elements, begin, end); });
  });
}

template <class Real>
void CpuBackend<Real>::gather_elements(Span<const Real> from, Span<const int64_t> index, int width,
                                       int64_t inherited, Span<Real> to) {
  check(to.size == index.size * width, "gather_elements: target size");
  parallel_for(index.size, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      Real* element = to.data + i * width;
      if (i >= inherited || index[i] < 0)
        std::fill_n(element, width, Real(0));
      else
        std::copy_n(from.data + index[i] * width, width, element);
    }
  });
}

template <class Real>
void CpuBackend<Real>::add_to_mean(Span<const Real> values, Real weight, Span<Real> mean) {
  constexpr int64_t kGrain = 1 << 16;  // scalars per task
  parallel_for(values.size, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) mean[i] += weight * (values[i] - mean[i]);
  });
}

template <class Real>
void CpuBackend<Real>::limit_values(Span<Real> values, Real limit) {
  for (Real& value : values) value = std::min(value, limit);
}

template <class Real>
void CpuBackend<Real>::fill_zero(Span<Real> values) {
  std::fill(values.begin(), values.end(), Real(0));
}

#define TESSERA_INSTANTIATE(Real)                                                             \
  template void CpuBackend<Real>::adam(const SinkArgs<Real>&);                                \
  template void CpuBackend<Real>::gather_elements(Span<const Real>, Span<const int64_t>, int, \
                                                  int64_t, Span<Real>);                       \
  template void CpuBackend<Real>::add_to_mean(Span<const Real>, Real, Span<Real>);            \
  template void CpuBackend<Real>::limit_values(Span<Real>, Real);                             \
  template void CpuBackend<Real>::fill_zero(Span<Real>);
TESSERA_INSTANTIATE(float)
TESSERA_INSTANTIATE(double)

}  // namespace tessera
