// Histograms of a model: the number of Gaussians that need each SH degree, and the temporal extents
// of the dynamic ones.
#pragma once
#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>

#include "kernels/math/spherical_harmonics.h"
#include "recon4d/model/gaussian_set.h"

namespace tessera {

/// Edges between the bins of temporal extents, in lengths of the clip: 1/256, 1/128, …, 4. The
/// first bin lies below the first edge, the last at and above the last.
inline constexpr int kExtentBins = 12;
double extent_edge(int edge);  // 0 … kExtentBins − 2

/// Of sound Gaussians.
struct ModelHistograms {
  /// By the highest active degree with a coefficient that is not zero, levels of time too.
  std::array<int64_t, kMaxShDegree + 1> static_degrees{}, dynamic_degrees{};
  /// Dynamic Gaussians that are drawn within the clip, by σ_t, the model's temporal filter in it.
  std::array<int64_t, kExtentBins> extents{};
  int64_t never_drawn = 0;  // dynamic ones that are not
};
ModelHistograms histograms_of(const GaussianModel& model);

/// `sh_degrees` {static, dynamic: counts of degree 0 … 3}; `temporal_extents` {edges_clip,
/// edges_seconds, counts (one more than edges), never_drawn}.
nlohmann::json to_json(const ModelHistograms& histograms, const TimeAxis& time_axis);

}  // namespace tessera
