// The rules by which Gaussians are drawn, as one value that options, models and files share, and
// the names of the rules in files.
#pragma once
#include <string>

#include "kernels/math/bounds.h"
#include "kernels/math/spherindrical.h"

namespace tessera {

/// A model looks right only when it is drawn as it was trained.
struct DrawingRules {
  int sh_degree = kMaxShDegree;         // bands evaluated, of those that are stored
  int sh_time_degree = kMaxTimeLevels;  // levels of time evaluated, of those that are stored
  double sh_time_period = 1;            // T of the levels, normalised time
  double near_plane = 0.2;              // world units along the viewing axis
  double far_plane = 1e4;
  bool sliced_direction = true;  // colours look along eye → mean at the view's timestep; else → μ
  double truncation_sigma = kTruncationSigma;  // where splats end (Cutoff), standard deviations
  bool truncation_by_falloff = false;          // whatever their opacity
  bool filter_2d = false;                      // dilation 0.1 with compensation, else 0.3 without
  double time_filter = 0;                      // added to σ_t² in the marginal, normalised time²

  bool operator==(const DrawingRules&) const = default;
};

template <class Real>
Cutoff<Real> make_cutoff(const DrawingRules& rules) {
  return make_cutoff<Real>(rules.truncation_sigma, rules.truncation_by_falloff);
}

/// visit(name, rule) of each rule, in the order of files. `Rules`: DrawingRules, const or not.
template <class Rules, class Visit>
void for_each_rule(Rules& rules, Visit&& visit) {
  visit("sh_degree", rules.sh_degree);
  visit("sh_time_degree", rules.sh_time_degree);
  visit("sh_time_period", rules.sh_time_period);
  visit("near_plane", rules.near_plane);
  visit("far_plane", rules.far_plane);
  visit("sliced_direction", rules.sliced_direction);
  visit("truncation_sigma", rules.truncation_sigma);
  visit("truncation_by_falloff", rules.truncation_by_falloff);
  visit("filter_2d", rules.filter_2d);
  visit("time_filter", rules.time_filter);
}

/// What is wrong with rules by which nothing can be drawn, such as "near_plane is -1, expected more
/// than 0"; empty where nothing is.
std::string wrong_rule(const DrawingRules& rules);

}  // namespace tessera
