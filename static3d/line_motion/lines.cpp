// Parts what stands still from what moves.
#include "static3d/line_motion/lines.h"

#include <algorithm>
#include <cmath>

#include "kernels/math/spherical_harmonics.h"
#include "recon4d/model/element_edits.h"
#include "static3d/formats/splat_file.h"

namespace tessera {
namespace {

bool stands_still(const GaussianSpans<const float>& lines, int64_t n) {
  constexpr double kShare = 1e-3, kLeastOpacity = 0.995;
  const float* const scale = lines.at(kLogScale, n);
  const float* const v = lines.at(kVelocity, n);
  const double smallest = std::exp(double(std::min({scale[0], scale[1], scale[2]})));
  if (std::hypot(double(v[0]), double(v[1]), double(v[2])) > kShare * smallest) return false;
  const double time = *lines.at(kMeanTime, n);
  const double far = std::max(std::abs(time), std::abs(1 - time));
  const double deviations = far / std::exp(double(*lines.at(kLogScaleTime, n)));
  return std::exp(-0.5 * deviations * deviations) >= kLeastOpacity;
}

}  // namespace

GaussianSet joined_sets(const std::vector<const GaussianSet*>& sets, SetForm form,
                        int coefficients) {
  int64_t count = 0;
  for (const GaussianSet* set : sets) count += set->count();
  GaussianSet all(form, coefficients);
  all.resize(count);
  const GaussianSpans<float> target = all.values();
  for (int g = 0; g < all.groups(); ++g)
    std::fill_n(target.group[g].data, target.group[g].size, 0.0f);
  int64_t first = 0;
  for (const GaussianSet* set : sets) {
    const GaussianSpans<const float> source = set->values();
    for (int g = 0; g < std::min(set->groups(), all.groups()); ++g) {
      const int width = std::min(set->width(Group(g)), all.width(Group(g)));
      for (int64_t n = 0; n < set->count(); ++n)
        std::copy_n(source.at(Group(g), n), width, target.at(Group(g), first + n));
    }
    first += set->count();
  }
  return all;
}

GaussianSet joined_lines(const std::vector<GaussianSet>& sets) {
  std::vector<const GaussianSet*> all;
  int coefficients = 1;
  for (const GaussianSet& set : sets) {
    all.push_back(&set);
    coefficients = std::max(coefficients, set.coefficients());
  }
  return joined_sets(all, SetForm::kVelocity, coefficients);
}

GaussianSet sound_set(const GaussianSet& set) {
  GaussianSet sound = select_elements(set, valid_elements(set));
  normalise_rotations(sound);
  return sound;
}

int drawn_degree(const GaussianModel& model) {
  int most = 1;
  for (const GaussianSet* set : {&model.static_set, &model.dynamic_set})
    if (set->count() > 0) most = std::max(most, set->coefficients());
  return std::min(model.drawing.sh_degree, sh_degree_of(most));
}

GaussianSet lines_of(const GaussianModel& model, int degree, double still_extent) {
  GaussianSet lines = joined_sets({&model.static_set, &model.dynamic_set}, SetForm::kVelocity,
                                  sh_coefficients(degree));
  const GaussianSpans<float> values = lines.values();
  for (int64_t n = 0; n < model.static_set.count(); ++n) {
    *values.at(kMeanTime, n) = 0.5f;
    *values.at(kLogScaleTime, n) = float(std::log(still_extent));
  }
  return sound_set(lines);
}

GaussianModel model_of_lines(const GaussianSet& lines, const TimeAxis& axis) {
  const GaussianSpans<const float> values = lines.values();
  std::vector<int64_t> still, moving;
  for (int64_t n = 0; n < lines.count(); ++n)
    (stands_still(values, n) ? still : moving).push_back(n);
  GaussianModel model;
  model.time_axis = axis;
  model.drawing.sh_degree = sh_degree_of(lines.coefficients());
  const GaussianSet at_rest = select_elements(lines, still);
  model.static_set = joined_sets({&at_rest}, SetForm::kStatic, lines.coefficients());
  model.dynamic_set = select_elements(lines, moving);
  return model;
}

}  // namespace tessera
