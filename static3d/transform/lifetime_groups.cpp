// Visible intervals, the features that the palette compares, and the means of groups.
#include "static3d/transform/lifetime_groups.h"

#include <algorithm>
#include <cmath>

#include "static3d/transform/vector_palette.h"

namespace tessera {
namespace {

constexpr double kAtRest = 1e-4;     // of the extent: displacement during the clip
constexpr double kLogWeight = 0.25;  // of ln σ among features whose unit is the clip or the scene
constexpr int kFeatures = 5;

/// σ of the marginal in time, with the temporal filter.
double sigma_of(const MovingGaussian& g, double time_filter) {
  return std::sqrt(1 / double(g.spacetime.precision_time) + time_filter);
}

/// Half of the interval where exp(−½ Δ²/σ²) exceeds 1/2.
double half_life(double sigma) {
  return sigma * std::sqrt(2 * std::log(2.0));
}

}  // namespace

LifetimeGroups lifetime_groups(const std::vector<MovingGaussian>& moving, double time_filter,
                               double extent, int64_t most) {
  LifetimeGroups result;
  std::vector<int64_t> grouped;
  std::vector<float> features;
  const double unit = extent > 0 ? extent : 1;
  for (size_t i = 0; i < moving.size(); ++i) {
    const MovingGaussian& g = moving[i];
    const double sigma = sigma_of(g, time_filter), half = half_life(sigma);
    const double mean_time = g.spacetime.mean_time;
    const Vec3<double> velocity(g.spacetime.velocity);
    if (mean_time + half <= 0 || mean_time - half >= 1) {
      result.never_drawn.push_back(int64_t(i));
    } else if (mean_time - half <= 0 && mean_time + half >= 1 &&
               glm::length(velocity) <= kAtRest * unit) {
      result.fixed.push_back(int64_t(i));
    } else {
      grouped.push_back(int64_t(i));
      features.push_back(float(mean_time));
      features.push_back(float(kLogWeight * std::log(sigma)));
      for (int k = 0; k < 3; ++k)
        features.push_back(float(velocity[k] * std::min(sigma, 1.0) / unit));
    }
  }
  if (grouped.empty()) return result;
  const VectorPalette palette = vector_palette(features, kFeatures, most);
  result.groups.resize(size_t(palette.count()));
  for (size_t i = 0; i < grouped.size(); ++i)
    result.groups[size_t(palette.labels[i])].members.push_back(grouped[i]);
  std::erase_if(result.groups, [](const LifetimeGroup& g) { return g.members.empty(); });
  double error = 0;
  for (LifetimeGroup& group : result.groups) {
    const double share = 1 / double(group.members.size());
    group.begin = group.end = 0;
    for (const int64_t i : group.members) {
      const MovingGaussian& g = moving[size_t(i)];
      const double half = half_life(sigma_of(g, time_filter)), mean_time = g.spacetime.mean_time;
      group.begin += share * std::max(mean_time - half, 0.0);
      group.end += share * std::min(mean_time + half, 1.0);
      group.mean_time += share * mean_time;
      group.velocity += share * Vec3<double>(g.spacetime.velocity);
    }
    for (const int64_t i : group.members) {  // mean of |(v − v̄)Δ|² over the visible interval
      const MovingGaussian& g = moving[size_t(i)];
      const double half = std::min(half_life(sigma_of(g, time_filter)), 1.0);
      const Vec3<double> other = Vec3<double>(g.spacetime.velocity) - group.velocity;
      error += dot(other, other) * half * half / 3;
    }
  }
  result.rms_error = std::sqrt(error / double(grouped.size()));
  std::stable_sort(result.groups.begin(), result.groups.end(),
                   [](const auto& a, const auto& b) { return a.begin < b.begin; });
  return result;
}

}  // namespace tessera
