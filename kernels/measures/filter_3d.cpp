// Sizes of the 3D filter and the edits that follow from them, over all Gaussians on the CPU.
// Source: method C.1.
#include <algorithm>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/measures/filter_3d.h"

namespace tessera {
namespace {

constexpr int64_t kGrain = 512;  // Gaussians per task

}  // namespace

template <class Real>
void CpuBackend<Real>::filter_sizes(const FilterArgs<Real>& args, Span<Real> sizes) {
  check(sizes.size == args.set.count, "filter_sizes: one size a Gaussian");
  const std::vector<ViewArgs<Real>>& views = args.views->views;
  parallel_for(args.set.count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) {
      sizes[n] = with_form(args.set.form, [&](auto form) {
        return filter_size_in<form()>(args.set, n, views.data(), int64_t(views.size()),
                                      args.near_plane, args.focal, args.time_filter);
      });
    }
  });
  Real largest = Real(0);
  for (const Real size : sizes) largest = std::max(largest, size);
  for (Real& size : sizes) size = size < Real(0) ? largest : size;
}

template <class Real>
void CpuBackend<Real>::edit_by_filter(FilterEdit edit, const GaussianSpans<Real>& set, Real limit) {
  check(set.filter_size.size == set.count, "edit_by_filter: one size a Gaussian");
  parallel_for(set.count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) tessera::edit_by_filter(edit, set, n, limit);
  });
}

template void CpuBackend<float>::filter_sizes(const FilterArgs<float>&, Span<float>);
template void CpuBackend<double>::filter_sizes(const FilterArgs<double>&, Span<double>);
template void CpuBackend<float>::edit_by_filter(FilterEdit, const GaussianSpans<float>&, float);
template void CpuBackend<double>::edit_by_filter(FilterEdit, const GaussianSpans<double>&, double);

}  // namespace tessera
