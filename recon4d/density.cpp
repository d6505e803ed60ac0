// What: which Gaussians are cloned, split, pruned, in which order the survivors stand.
// Not: gradients or schedules.
#include "recon4d/density.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/math/random.h"
#include "kernels/math/splat.h"
#include "recon4d/locality_order.h"

namespace tessera {
namespace {

const float kSplitShrink = std::log(1.6f);  // children are this much smaller  [3DGS]

/// The rows that make up the new set. Order: survivors, clones, first children, second children.
struct Selection {
  std::vector<int64_t> survivors, clones, parents;

  int64_t count() const { return int64_t(survivors.size() + clones.size() + 2 * parents.size()); }
};

float largest_log_scale(const GaussianSpans<const float>& v, int64_t n) {
  const float* s = v.at(kLogScale, n);
  return std::max({s[0], s[1], s[2]});
}

bool degenerate(const GaussianSpans<const float>& v, int64_t n) {
  const auto short_quaternion = [&](Group group) {
    const Vec4<float> q = load4(v.at(group, n));
    return !(dot(q, q) >= kMinQuaternionNorm2<float>);
  };
  return short_quaternion(kRotation) || (v.dim == 4 && short_quaternion(kRotationRight));
}

/// Candidates to grow, strongest gradient first where room is short.
std::vector<int64_t> candidates(const DensityContext& context, const SetStatistics& statistics,
                                const std::vector<char>& kept, int64_t room) {
  std::vector<int64_t> chosen;
  const auto score = [&](int64_t n) {
    return statistics.gradient_sum[n] / std::max(statistics.count[n], 1.0f);
  };
  for (int64_t n = 0; n < int64_t(kept.size()); ++n)
    if (kept[size_t(n)] && statistics.count[n] > 0 &&
        score(n) >= float(context.options.densify_threshold))
      chosen.push_back(n);
  if (room < 0 || int64_t(chosen.size()) <= room) return chosen;
  std::stable_sort(chosen.begin(), chosen.end(),
                   [&](int64_t a, int64_t b) { return score(a) > score(b); });
  chosen.resize(size_t(room));
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

Selection select(const DensityContext& context, const GaussianSet& set,
                 const SetStatistics& statistics, DensityReport& report) {
  const GaussianSpans<const float> v = set.values();
  const float logit_limit =
      float(std::log(context.options.prune_opacity / (1 - context.options.prune_opacity)));
  const float small = float(std::log(context.options.dense_fraction * context.extent));
  const float large = float(std::log(context.options.prune_extent * context.extent));
  std::vector<char> kept(size_t(set.count()), 0), parent(size_t(set.count()), 0);
  int64_t pruned = 0;
  for (int64_t n = 0; n < set.count(); ++n) {
    kept[size_t(n)] = *v.at(kOpacityLogit, n) >= logit_limit && !degenerate(v, n);
    pruned += !kept[size_t(n)];
  }
  Selection selection;
  const int64_t room = context.room < 0 ? -1 : context.room + pruned;
  for (int64_t n : candidates(context, statistics, kept, room)) {
    const float scale = largest_log_scale(v, n);
    const bool too_large = context.prune_large && scale > large;
    if (scale <= small && !too_large) {
      selection.clones.push_back(n);
    } else if (scale > small) {
      parent[size_t(n)] = 1;
      // children are pruned by the same rule as everyone else
      if (!(context.prune_large && scale - kSplitShrink > large)) selection.parents.push_back(n);
    }
  }
  for (int64_t n = 0; n < set.count(); ++n) {
    const bool too_large = context.prune_large && largest_log_scale(v, n) > large;
    if (kept[size_t(n)] && !parent[size_t(n)] && !too_large) selection.survivors.push_back(n);
  }
  report = {int64_t(selection.clones.size()), int64_t(selection.parents.size()),
            set.count() - int64_t(selection.survivors.size() + selection.parents.size()),
            set.count(), selection.count()};
  return selection;
}

/// Puts row index[i] at place i of every group; moments of places ≥ `inherited` become zero.
void gather(Backend& backend, GaussianSet& set, const std::vector<int64_t>& index,
            int64_t inherited) {
  std::vector<int64_t> moment_index = index;
  std::fill(moment_index.begin() + inherited, moment_index.end(), -1);
  const auto gathered = [&](Buffer<float>& from, const std::vector<int64_t>& rows, int width) {
    Buffer<float> to(int64_t(rows.size()) * width, backend.memory());
    backend.gather_rows(from.span(), {rows.data(), int64_t(rows.size())}, width, to.span());
    from = std::move(to);
  };
  const bool moments = set.has_moments();
  for (int g = 0; g < set.groups(); ++g) {
    ParameterGroup& group = set.group(Group(g));
    const int width = set.width(Group(g));
    gathered(group.value, index, width);
    if (moments) {
      gathered(group.moment1, moment_index, width);
      gathered(group.moment2, moment_index, width);
    }
  }
  set.set_count(int64_t(index.size()));
}

/// Moves the child at row n to a sample of its parent's distribution and shrinks it.
template <int Dim>
void place_child(const GaussianSpans<float>& v, int64_t n, const RandomBlock& random) {
  const Vec4<float> noise = normals(random);
  float* s = v.at(kLogScale, n);
  if constexpr (Dim == 4) {
    const Mat4<float> R = rotation4(load4(v.at(kRotation, n)), load4(v.at(kRotationRight, n)));
    float* s_t = v.at(kLogScaleTime, n);
    const Vec4<float> along(noise[0] * exp(*s_t), noise[1] * exp(s[0]), noise[2] * exp(s[1]),
                            noise[3] * exp(s[2]));
    for (int i = 0; i < 4; ++i) {
      float& target = i == 0 ? *v.at(kMeanTime, n) : v.at(kMean, n)[i - 1];
      for (int k = 0; k < 4; ++k) target += R.m[i][k] * along[k];
    }
    *s_t -= kSplitShrink;
  } else {
    const Mat3<float> R = rotation_matrix(load4(v.at(kRotation, n)));
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) v.at(kMean, n)[i] += R[k][i] * noise[k] * exp(s[k]);
  }
  for (int k = 0; k < 3; ++k) s[k] -= kSplitShrink;
}

}  // namespace

void SetStatistics::reset(int64_t gaussians) {
  gradient_sum.resize(gaussians);
  count.resize(gaussians);
  std::fill(gradient_sum.begin(), gradient_sum.end(), 0.0f);
  std::fill(count.begin(), count.end(), 0.0f);
}

DensityReport control_density(Backend& backend, const DensityContext& context, GaussianSet& set,
                              SetStatistics& statistics) {
  DensityReport report;
  const Selection selection = select(context, set, statistics, report);
  std::vector<int64_t> index = selection.survivors;
  const int64_t inherited = int64_t(index.size());
  index.insert(index.end(), selection.clones.begin(), selection.clones.end());
  const int64_t first_child = int64_t(index.size());
  for (int copy = 0; copy < 2; ++copy)
    index.insert(index.end(), selection.parents.begin(), selection.parents.end());
  gather(backend, set, index, inherited);
  const GaussianSpans<float> v = set.values();
  for (int64_t n = first_child; n < set.count(); ++n) {
    const RandomBlock random = philox(uint64_t(context.options.seed) ^ context.draw << 20,
                                      RandomStream::kSplit, uint64_t(n), uint32_t(set.dim()));
    set.dim() == 4 ? place_child<4>(v, n, random) : place_child<3>(v, n, random);
  }
  statistics.reset(set.count());
  return report;
}

void reset_opacity(GaussianSet& set) {
  constexpr float kResetLogit = -4.595119953155518f;  // logit 0.01  [3DGS]
  ParameterGroup& group = set.group(kOpacityLogit);
  for (float& value : group.value) value = std::min(value, kResetLogit);
  std::fill(group.moment1.begin(), group.moment1.end(), 0.0f);
  std::fill(group.moment2.begin(), group.moment2.end(), 0.0f);
}

void reorder(Backend& backend, GaussianSet& set, SetStatistics& statistics) {
  if (set.count() == 0) return;
  const std::vector<int64_t> order = locality_order(set);
  gather(backend, set, order, int64_t(order.size()));
  for (Buffer<float>* values : {&statistics.gradient_sum, &statistics.count}) {
    Buffer<float> sorted(set.count());
    backend.gather_rows(values->span(), {order.data(), int64_t(order.size())}, 1, sorted.span());
    *values = std::move(sorted);
  }
}

int64_t prune_invisible(Backend& backend, GaussianSet& set, SetStatistics& statistics) {
  const GaussianSpans<const float> v = std::as_const(set).values();
  std::vector<int64_t> index;
  for (int64_t n = 0; n < set.count(); ++n)
    if (sigmoid(*v.at(kOpacityLogit, n)) >= kMinAlpha<float> && !degenerate(v, n))
      index.push_back(n);
  const int64_t removed = set.count() - int64_t(index.size());
  if (removed > 0) gather(backend, set, index, int64_t(index.size()));
  statistics.reset(set.count());
  return removed;
}

}  // namespace tessera
