// MCMC densification on the CPU: dead Gaussians become copies of alive ones, copies are added, and
// means take random steps. The formulas are in math/relocation.h and mcmc.h. Source: method B.
#include "kernels/edits/mcmc.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"

namespace tessera {
namespace {

constexpr int64_t kGrain = 1024;  // Gaussians per task

/// The dead Gaussians, and Σ of the weights before each of the others.
struct Weighed {
  std::vector<char> dead;     // [N]
  std::vector<int64_t> sums;  // [N+1]
};

template <SetForm form, class Real>
Weighed weigh(const GaussianSpans<const Real>& set, double dead_opacity) {
  Weighed out{std::vector<char>(size_t(set.count)), std::vector<int64_t>(size_t(set.count + 1))};
  parallel_for(set.count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) {
      const double opacity = living_opacity<form>(set, n);
      out.dead[size_t(n)] = !(opacity > dead_opacity);
      out.sums[size_t(n + 1)] = out.dead[size_t(n)] ? 0 : draw_weight(opacity);
    }
  });
  for (int64_t n = 0; n < set.count; ++n) out.sums[size_t(n + 1)] += out.sums[size_t(n)];
  return out;
}

template <SetForm form, class Real>
void relocate(const GaussianSpans<Real>& set, const RelocationRule& rule,
              RelocationElements& elements) {
  const Weighed weighed = weigh<form>(set.view(), rule.dead_opacity);
  elements.moved = 0;
  elements.weight = weighed.sums.back();
  check(rule.added == 0 || elements.weight > 0, "relocate_elements: no Gaussian to copy");
  elements.values.resize(set.count + rule.added);
  elements.moments.resize(set.count + rule.added);
  std::vector<int32_t> copies(size_t(set.count), 1);
  for (int64_t i = 0; i < elements.values.size(); ++i) {
    elements.values[i] = elements.moments[i] = i;
    const bool is_new = i >= set.count;
    if (!is_new && (!weighed.dead[size_t(i)] || elements.weight == 0)) continue;
    elements.values[i] = drawn_source(weighed.sums.data(), set.count, rule.seed, i);
    ++copies[size_t(elements.values[i])];
    if (is_new)
      elements.moments[i] = -1;
    else
      ++elements.moved;  // with the moments that it has
  }
  for (int64_t n = 0; n < set.count; ++n) {
    if (copies[size_t(n)] == 1) continue;
    become_copies<form>(set, n, copies[size_t(n)], rule.least_opacity);
    elements.moments[n] = -1;
  }
}

}  // namespace

template <class Real>
void CpuBackend<Real>::relocate_elements(const GaussianSpans<Real>& set, const RelocationRule& rule,
                                         RelocationElements& elements) {
  with_form(set.form, [&](auto form) { relocate<form()>(set, rule, elements); });
}

template <class Real>
void CpuBackend<Real>::add_position_noise(const GaussianSpans<Real>& set,
                                          const PositionNoise& noise) {
  parallel_for(set.count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n)
      with_form(set.form, [&](auto form) { tessera::add_position_noise<form()>(set, n, noise); });
  });
}

#define TESSERA_INSTANTIATE(Real)                                                                \
  template void CpuBackend<Real>::relocate_elements(const GaussianSpans<Real>&,                  \
                                                    const RelocationRule&, RelocationElements&); \
  template void CpuBackend<Real>::add_position_noise(const GaussianSpans<Real>&,                 \
                                                     const PositionNoise&);
TESSERA_INSTANTIATE(float)
TESSERA_INSTANTIATE(double)

}  // namespace tessera
