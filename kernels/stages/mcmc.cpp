// What: dead Gaussians become copies of living ones, copies are added, means take random steps.
// Not: when (recon4d/density/mcmc.h); what becomes of one Gaussian is in math/relocation.h and
// elements/position_noise.h.
// Source: method B.
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/elements/position_noise.h"
#include "kernels/elements/relocation.h"

namespace tessera {
namespace {

constexpr int64_t kGrain = 1024;  // Gaussians per task

/// Who is dead, and Σ of the weights before each of the others.
struct Weighed {
  std::vector<char> dead;     // [N]
  std::vector<int64_t> sums;  // [N+1]
};

template <Form form, class Real>
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

template <Form form, class Real>
void relocate(const GaussianSpans<Real>& set, const RelocationRule& rule, RelocationRows& rows) {
  const Weighed weighed = weigh<form>(set.view(), rule.dead_opacity);
  rows.moved = 0, rows.weight = weighed.sums.back();
  check(rule.added == 0 || rows.weight > 0, "relocate_rows: nobody to copy");
  rows.values.resize(set.count + rule.added);
  rows.moments.resize(set.count + rule.added);
  std::vector<int32_t> copies(size_t(set.count), 1);
  for (int64_t i = 0; i < rows.values.size(); ++i) {
    rows.values[i] = rows.moments[i] = i;
    const bool is_new = i >= set.count;
    if (!is_new && (!weighed.dead[size_t(i)] || rows.weight == 0)) continue;
    rows.values[i] = drawn_source(weighed.sums.data(), set.count, rule.seed, i);
    ++copies[size_t(rows.values[i])];
    if (is_new)
      rows.moments[i] = -1;
    else
      ++rows.moved;  // with the moments that it has
  }
  for (int64_t n = 0; n < set.count; ++n) {
    if (copies[size_t(n)] == 1) continue;
    become_copies<form>(set, n, copies[size_t(n)], rule.least_opacity);
    rows.moments[n] = -1;
  }
}

}  // namespace

template <class Real>
void CpuBackend<Real>::relocate_rows(const GaussianSpans<Real>& set, const RelocationRule& rule,
                                     RelocationRows& rows) {
  with_form(set.form, [&](auto form) { relocate<form()>(set, rule, rows); });
}

template <class Real>
void CpuBackend<Real>::add_position_noise(const GaussianSpans<Real>& set,
                                          const PositionNoise& noise) {
  parallel_for(set.count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n)
      with_form(set.form, [&](auto form) { tessera::add_position_noise<form()>(set, n, noise); });
  });
}

#define TESSERA_INSTANTIATE(Real)                                                                  \
  template void CpuBackend<Real>::relocate_rows(const GaussianSpans<Real>&, const RelocationRule&, \
                                                RelocationRows&);                                  \
  template void CpuBackend<Real>::add_position_noise(const GaussianSpans<Real>&,                   \
                                                     const PositionNoise&);
TESSERA_INSTANTIATE(float)
TESSERA_INSTANTIATE(double)

}  // namespace tessera
