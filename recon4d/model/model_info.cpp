// Counts, bounds and percentiles over the valid Gaussians of a model.
#include "recon4d/model/model_info.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "kernels/load_gaussian.h"
#include "recon4d/model/element_edits.h"
#include "recon4d/options/choices.h"

namespace tessera {
namespace {

using nlohmann::json;

/// What is gathered over both sets.
struct Facts {
  std::vector<float> opacity, scale, temporal_extent, speed;
  Vec3<float> low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
  int64_t sound = 0;
};

template <SetForm form>
void gather(const GaussianSet& set, Facts& facts) {
  const GaussianSpans<const float> values = set.values();
  for (int64_t n : valid_elements(set)) {
    GaussianState<float> g;
    if (!load_gaussian<form>(values, n, g)) continue;
    ++facts.sound;
    facts.low = glm::min(facts.low, g.mean);
    facts.high = glm::max(facts.high, g.mean);
    facts.opacity.push_back(g.opacity);
    for (int axis = 0; axis < 3; ++axis)
      facts.scale.push_back(std::exp(values.at(kLogScale, n)[axis]));
    if constexpr (is_dynamic(form)) {
      facts.temporal_extent.push_back(1.0f / std::sqrt(g.spacetime.precision_time));
      facts.speed.push_back(std::sqrt(dot(g.spacetime.velocity, g.spacetime.velocity)));
    }
  }
}

/// Nearest rank; null without values.
json percentiles(std::vector<float>& values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  const auto rank = [&](double fraction) {
    return values[size_t(std::llround(fraction * double(values.size() - 1)))];
  };
  return {{"min", rank(0)},   {"p1", rank(0.01)},  {"p10", rank(0.1)}, {"p50", rank(0.5)},
          {"p90", rank(0.9)}, {"p99", rank(0.99)}, {"max", rank(1)}};
}

json point(const Vec3<float>& p) {
  return {p[0], p[1], p[2]};
}

}  // namespace

json model_info(const GaussianModel& model) {
  Facts facts;
  for (const GaussianSet* set : {&model.static_set, &model.dynamic_set})
    with_form(set->form(), [&](auto form) { gather<form()>(*set, facts); });
  json info;
  info["num_gaussians"] = model.count();
  info["num_static"] = model.static_set.count();
  info["num_dynamic"] = model.dynamic_set.count();
  if (!model.nodes.empty())
    info["motion_nodes"] = {{"count", model.nodes.count}, {"knots", model.nodes.knots}};
  info["num_unsound"] = model.count() - facts.sound;
  info["motion_form"] = dynamic_form_name(model.dynamic_set.form());
  info["sh_degree"] = model.drawing.sh_degree;
  info["sh_coefficients"] = {{"static", model.static_set.coefficients()},
                             {"dynamic", model.dynamic_set.coefficients()}};
  info["sh_time"] = {{"degree", model.drawing.sh_time_degree},
                     {"levels", model.dynamic_set.time_levels()},
                     {"period", model.drawing.sh_time_period}};
  info["value_bytes"] = model.static_set.value_bytes() + model.dynamic_set.value_bytes();
  info["bounds"] = facts.sound == 0 ? json(nullptr)
                                    : json{{"min", point(facts.low)}, {"max", point(facts.high)}};
  info["opacity"] = percentiles(facts.opacity);
  info["scale"] = percentiles(facts.scale);
  info["temporal_extent"] = percentiles(facts.temporal_extent);
  info["speed"] = percentiles(facts.speed);
  info["time_axis"] = {{"origin", model.time_axis.origin}, {"duration", model.time_axis.duration}};
  info["world"] = model.prepared_from_source.is_identity() ? "source" : "prepared";
  info["background"] = model.background;
  info["environment"] = model.environment.height > 0 ? json{{"height", model.environment.height},
                                                            {"width", 2 * model.environment.height}}
                                                     : json(nullptr);
  info["clip_planes"] = {model.drawing.near_plane, model.drawing.far_plane};
  info["truncation"] = {{"sigma", model.drawing.truncation_sigma},
                        {"by_falloff", model.drawing.truncation_by_falloff}};
  info["filter_2d"] = model.drawing.filter_2d;
  info["time_filter"] = model.drawing.time_filter;
  info["train_scale"] = model.train_scale;
  return info;
}

}  // namespace tessera
