// Density control of a set on the CPU as lists of elements, the children of splits, and the order
// of a set in memory. The rule for one Gaussian is in density.h. Source: method A.13, A.14, D.7.
#include <algorithm>
#include <limits>
#include <numeric>

#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/edits/density.h"
#include "kernels/math/sort_keys.h"

namespace tessera {
namespace {

/// Those that are to grow, in the order of their keys where room is short.
template <class Real>
std::vector<char> growing(const DensityLimits<Real>& limits, const GaussianSpans<const Real>& set,
                          const DensityStatistics<const Real>& statistics, int64_t room) {
  std::vector<int64_t> chosen;
  const auto score = [&](int64_t n) { return candidate_score(limits, set, statistics, n); };
  for (int64_t n = 0; n < set.count; ++n)
    if (score(n) >= 0) chosen.push_back(n);
  if (room >= 0 && int64_t(chosen.size()) > room) {
    std::vector<uint32_t> key(size_t(set.count));
    for (const int64_t n : chosen) key[size_t(n)] = growth_key(limits, score(n), n);
    std::stable_sort(chosen.begin(), chosen.end(),
                     [&](int64_t a, int64_t b) { return key[size_t(a)] < key[size_t(b)]; });
    chosen.resize(size_t(room));
  }
  std::vector<char> grows(size_t(set.count), 0);
  for (const int64_t n : chosen) grows[size_t(n)] = 1;
  return grows;
}

}  // namespace

template <class Real>
void CpuBackend<Real>::select_elements(const GaussianSpans<const Real>& set,
                                       const DensityStatistics<const Real>& statistics,
                                       const DensityRule& rule, DensityElements& elements) {
  const DensityLimits<Real> limits = density_limits<Real>(rule);
  std::vector<char> alive(size_t(set.count), 0);
  int64_t dead = 0;
  for (int64_t n = 0; n < set.count; ++n) {
    alive[size_t(n)] = is_alive(limits, set, n);
    dead += !alive[size_t(n)];
  }
  const std::vector<char> grows =
      growing(limits, set, statistics, rule.room < 0 ? -1 : rule.room + dead);
  std::vector<int64_t> survivors, clones, parents;
  for (int64_t n = 0; n < set.count; ++n) {
    if (!alive[size_t(n)]) continue;
    const Fate fate = fate_of(limits, set, n, grows[size_t(n)] != 0);
    if (fate == Fate::kKept || fate == Fate::kCloned) survivors.push_back(n);
    if (fate == Fate::kCloned) clones.push_back(n);
    if (fate == Fate::kSplit) parents.push_back(n);
  }
  elements.survivors = int64_t(survivors.size());
  elements.clones = int64_t(clones.size());
  elements.parents = int64_t(parents.size());
  elements.pruned = set.count - elements.survivors - elements.parents;
  elements.index.resize(elements.survivors + elements.clones + 2 * elements.parents);
  int64_t* out = elements.index.data();
  for (const auto* list : {&survivors, &clones, &parents, &parents})
    out = std::copy(list->begin(), list->end(), out);
}

template <class Real>
double CpuBackend<Real>::growth_weight(const GaussianSpans<const Real>& set,
                                       const DensityStatistics<const Real>& statistics,
                                       const DensityRule& rule) {
  const DensityLimits<Real> limits = density_limits<Real>(rule);
  double weight = 0;
  for (int64_t n = 0; n < set.count; ++n)
    weight += double(max_of(candidate_score(limits, set, statistics, n), Real(0)));
  return weight;
}

template <class Real>
void CpuBackend<Real>::place_children(const GaussianSpans<Real>& set, int64_t first,
                                      const SplitRule& rule) {
  for (int64_t n = first; n < set.count; ++n)
    with_form(set.form, [&](auto form) { place_child<form()>(set, first, n, rule); });
}

template <class Real>
void CpuBackend<Real>::locality_order(const GaussianSpans<const Real>& set,
                                      Buffer<int64_t>& order) {
  constexpr float kMost = std::numeric_limits<float>::max();
  LocalityBox box{{kMost, kMost, kMost, kMost}, {-kMost, -kMost, -kMost, -kMost}};
  const auto coordinate = [&](int64_t n, int axis) {
    return float(axis < 3 ? set.at(kMean, n)[axis] : *set.at(kMeanTime, n));
  };
  for (int64_t n = 0; n < set.count; ++n)
    for (int a = 0; a < set.dim(); ++a) {
      box.low[a] = std::min(box.low[a], coordinate(n, a));
      box.high[a] = std::max(box.high[a], coordinate(n, a));
    }
  std::vector<std::pair<uint32_t, uint64_t>> keys(size_t(set.count));
  for (int64_t n = 0; n < set.count; ++n)
    keys[size_t(n)] = {set.dim() == 4 ? time_bin(box, coordinate(n, 3)) : 0,
                       morton_code(box, coordinate(n, 0), coordinate(n, 1), coordinate(n, 2))};
  order.resize(set.count);
  std::iota(order.begin(), order.end(), int64_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](int64_t a, int64_t b) { return keys[size_t(a)] < keys[size_t(b)]; });
}

#define TESSERA_INSTANTIATE(Real)                                                                  \
  template void CpuBackend<Real>::select_elements(const GaussianSpans<const Real>&,                \
                                                  const DensityStatistics<const Real>&,            \
                                                  const DensityRule&, DensityElements&);           \
  template double CpuBackend<Real>::growth_weight(                                                 \
      const GaussianSpans<const Real>&, const DensityStatistics<const Real>&, const DensityRule&); \
  template void CpuBackend<Real>::place_children(const GaussianSpans<Real>&, int64_t,              \
                                                 const SplitRule&);                                \
  template void CpuBackend<Real>::locality_order(const GaussianSpans<const Real>&,                 \
                                                 Buffer<int64_t>&);
TESSERA_INSTANTIATE(float)
TESSERA_INSTANTIATE(double)

}  // namespace tessera
