// Sums of splats for each Gaussian and sums over images, on the CPU.
#include "kernels/measures/contribution.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"

namespace tessera {
namespace {

constexpr int64_t kElementGrain = 512, kValueGrain = 1 << 16;

/// Elements of a block whose first stands at `first` in the splats' numbering.
template <SetForm form, class Real>
void add_block(const ContributionArgs<Real>& args, const GaussianSpans<const Real>& set,
               int64_t first) {
  const RenderOptions& options = args.forward.options;
  const ColourRules<Real> colours =
      make_colour_rules<Real>(options, set.coefficients, set.time_levels);
  const Splats<Real>& splats = *args.splats;
  parallel_for(set.count, kElementGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) {
      const int64_t from = splats.first_of[first + n], to = splats.first_of[first + n + 1];
      GaussianState<Real> g;
      if (from == to || !load_gaussian<form>(set, n, g)) continue;
      TimeVariation* const variation =
          !is_dynamic(form) && !args.variation.empty() ? &args.variation[first + n] : nullptr;
      for (int64_t s = from; s < to; ++s) {
        const int b = splats.splat[s].view;
        GaussianState<Real> room;
        add_splat(args.forward.batch->views[size_t(b)], colours, Real(options.time_filter),
                  state_in_view<form>(set, n, b, g, room), splats.splat[s], args.sums[s],
                  args.elements[first + n], variation);
      }
    }
  });
}

}  // namespace

template <class Real>
void CpuBackend<Real>::contributions(const ContributionArgs<Real>& args) {
  check(args.sums.size == args.splats->count, "contributions: one sum a splat");
  int64_t first = 0;
  for (const GaussianSpans<const Real>& set : args.forward.sets) {
    for_each_block(set.blocks, set.count, set.coefficients, [&](const ShBlock& block) {
      with_drawn_form(set.form, [&](auto form) {
        add_block<form()>(args, set.block(block), first + block.first);
      });
    });
    first += set.count;
  }
}

template <class Real>
void CpuBackend<Real>::added_squares(const ViewBatch<Real>& batch, Span<const Real> before,
                                     Span<Real> residual) {
  for (const ViewArgs<Real>& view : batch.views) {
    const int64_t pixels = int64_t(view.width) * view.height, first = 3 * view.first_pixel;
    parallel_for(pixels, kValueGrain, [&](int64_t begin, int64_t end) {
      for (int64_t p = begin; p < end; ++p)
        write_added_squares(before.data + first, residual.data + first, pixels, p);
    });
  }
}

template <class Real>
double CpuBackend<Real>::sum_of_squares(Span<const Real> values) {
  std::vector<double> parts(size_t((values.size + kValueGrain - 1) / kValueGrain), 0.0);
  parallel_for(values.size, kValueGrain, [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t i = begin; i < end; ++i) sum += double(values[i]) * double(values[i]);
    parts[size_t(begin / kValueGrain)] = sum;
  });
  double sum = 0;
  for (const double part : parts) sum += part;
  return sum;
}

template void CpuBackend<float>::contributions(const ContributionArgs<float>&);
template void CpuBackend<double>::contributions(const ContributionArgs<double>&);
template void CpuBackend<float>::added_squares(const ViewBatch<float>&, Span<const float>,
                                               Span<float>);
template void CpuBackend<double>::added_squares(const ViewBatch<double>&, Span<const double>,
                                                Span<double>);
template double CpuBackend<float>::sum_of_squares(Span<const float>);
template double CpuBackend<double>::sum_of_squares(Span<const double>);

}  // namespace tessera
