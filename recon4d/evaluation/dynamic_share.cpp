// The recoloured model, its images, and sums over their pixels.
#include "recon4d/evaluation/dynamic_share.h"

#include <algorithm>

#include "kernels/base/errors.h"
#include "kernels/math/spherical_harmonics.h"

namespace tessera {
namespace {

/// The geometry and opacity of `set` in one grey, 0 or 1.
GaussianSet repainted(const GaussianSet& set, float grey) {
  GaussianSet result(set.form(), 1, set.memory());
  result.resize(set.count());
  for (int g = 0; g < set.groups(); ++g)
    if (g != kSh && g != kShTime) result.group(Group(g)).value.copy_from(set.group(Group(g)).value);
  Buffer<float> colour(host_memory());
  colour.resize(3 * set.count());
  std::fill(colour.begin(), colour.end(), (grey - 0.5f) / float(kSh0));
  result.group(kSh).value.copy_from(colour);
  return result;
}

}  // namespace

GaussianModel dynamic_set_white(const GaussianModel& model) {
  GaussianModel painted = model.clone_values();
  painted.static_set = repainted(model.static_set, 0);
  painted.dynamic_set = repainted(model.dynamic_set, 1);
  painted.environment = EnvironmentLight();
  painted.background = {0, 0, 0};
  painted.drawing.sh_degree = painted.drawing.sh_time_degree = 0;
  return painted;
}

std::vector<std::vector<float>> dynamic_share(Backend& backend, const GaussianModel& model,
                                              const std::vector<View>& views) {
  std::vector<std::vector<float>> shares;
  for (RenderedImage& image : render_views(backend, dynamic_set_white(model), views)) {
    image.rgb.resize(image.alpha.size());
    shares.push_back(std::move(image.rgb));
  }
  return shares;
}

void MovingRegionScore::add(const std::vector<float>& share, const std::vector<uint8_t>& mask,
                            const std::vector<uint8_t>& used) {
  check(share.size() == mask.size() && (used.empty() || used.size() == mask.size()),
        "moving region: share and masks of one size");
  for (size_t p = 0; p < mask.size(); ++p) {
    if (!used.empty() && used[p] == 0) continue;
    weight += share[p];
    if (mask[p] >= kRegion) weight_inside += share[p];
    moving_pixels += mask[p] >= kMovingNow;
    covered_pixels += mask[p] >= kMovingNow && share[p] >= kCovered;
  }
}

std::optional<double> MovingRegionScore::dynamic_weight_inside() const {
  return weight > 0 ? std::optional(weight_inside / weight) : std::nullopt;
}

std::optional<double> MovingRegionScore::moving_pixels_covered() const {
  return moving_pixels > 0 ? std::optional(double(covered_pixels) / double(moving_pixels))
                           : std::nullopt;
}

}  // namespace tessera
