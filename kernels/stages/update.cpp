// What: the optimizer as a stage of its own, and rows gathered by index (density control,
// ordering). Not: the fused optimizer, which is the ApplyAdam sink of project_backward.
#include <algorithm>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/stages/gradient_sink.h"

namespace tessera {
namespace {

constexpr int64_t kGrain = 1024;  // Gaussians or rows per task

template <int Dim, class Real>
void adam_run(const SinkArgs<Real>& args, int64_t begin, int64_t end) {
  const ApplyAdam<Real> sink{args.value, args.moment1, args.moment2, args.adam};
  for (int64_t n = begin; n < end; ++n) {
    ParameterGradient<Real> gradient;
    ParameterGradient<Real>::template for_each_group<Dim>(
        gradient, args.gradient.coefficients, [&](Group group, Real* g, int width) {
          std::copy_n(args.gradient.at(group, n), width, g);
        });
    sink.template accept<Dim>(n, gradient);
  }
}

}  // namespace

template <class Real>
void CpuBackend<Real>::adam(const SinkArgs<Real>& args) {
  parallel_for(args.value.count, kGrain, [&](int64_t begin, int64_t end) {
    if (args.value.dim == 4)
      adam_run<4>(args, begin, end);
    else
      adam_run<3>(args, begin, end);
  });
}

template <class Real>
void CpuBackend<Real>::gather_rows(Span<const Real> from, Span<const int64_t> index, int width,
                                   Span<Real> to) {
  check(to.size == index.size * width, "gather_rows: target size");
  parallel_for(index.size, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      Real* row = to.data + i * width;
      if (index[i] < 0)
        std::fill_n(row, width, Real(0));
      else
        std::copy_n(from.data + index[i] * width, width, row);
    }
  });
}

template void CpuBackend<float>::adam(const SinkArgs<float>&);
template void CpuBackend<double>::adam(const SinkArgs<double>&);
template void CpuBackend<float>::gather_rows(Span<const float>, Span<const int64_t>, int,
                                             Span<float>);
template void CpuBackend<double>::gather_rows(Span<const double>, Span<const int64_t>, int,
                                              Span<double>);

}  // namespace tessera
