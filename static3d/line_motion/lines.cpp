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

void copy_rows(const GaussianSet& from, int64_t first, GaussianSet& to) {
  const GaussianSpans<const float> source = from.values();
  const GaussianSpans<float> target = to.values();
  const int groups = std::min(from.groups(), to.groups());
  for (int g = 0; g < groups; ++g) {
    const int width = std::min(from.width(Group(g)), to.width(Group(g)));
    for (int64_t n = 0; n < from.count(); ++n)
      std::copy_n(source.at(Group(g), n), width, target.at(Group(g), first + n));
  }
}

int drawn_degree(const GaussianModel& model) {
  int most = 1;
  for (const GaussianSet* set : {&model.static_set, &model.dynamic_set})
    if (set->count() > 0) most = std::max(most, set->coefficients());
  return std::min(model.drawing.sh_degree, sh_degree_of(most));
}

GaussianSet lines_of(const GaussianModel& model, int degree, double still_extent) {
  const int64_t still = model.static_set.count();
  GaussianSet lines(SetForm::kVelocity, sh_coefficients(degree));
  lines.resize(model.count());
  for (int g = 0; g < lines.groups(); ++g)
    std::fill_n(lines.values().group[g].data, lines.values().group[g].size, 0.0f);
  copy_rows(model.static_set, 0, lines);
  copy_rows(model.dynamic_set, still, lines);
  const GaussianSpans<float> values = lines.values();
  for (int64_t n = 0; n < still; ++n) {
    *values.at(kMeanTime, n) = 0.5f;
    *values.at(kLogScaleTime, n) = float(std::log(still_extent));
  }
  lines = select_elements(lines, valid_elements(lines));
  normalise_rotations(lines);
  return lines;
}

GaussianModel model_of_lines(const GaussianSet& lines, const TimeAxis& axis) {
  const GaussianSpans<const float> values = lines.values();
  std::vector<int64_t> still, moving;
  for (int64_t n = 0; n < lines.count(); ++n)
    (stands_still(values, n) ? still : moving).push_back(n);
  GaussianModel model;
  model.time_axis = axis;
  model.drawing.sh_degree = sh_degree_of(lines.coefficients());
  model.static_set = GaussianSet(SetForm::kStatic, lines.coefficients());
  model.static_set.resize(int64_t(still.size()));
  copy_rows(select_elements(lines, still), 0, model.static_set);
  model.dynamic_set = select_elements(lines, moving);
  return model;
}

}  // namespace tessera
