// Conversion from pair to velocity by the axes of the slice, and from velocity to pair by the axes
// of space-time.
#include "static3d/transform/motion_form.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/load_gaussian.h"
#include "kernels/math/eigen3.h"
#include "kernels/math/four_rotation.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/model/element_edits.h"

namespace tessera {
namespace {

constexpr int64_t kGrain = 1024;
constexpr Group kShared[] = {kMean, kOpacityLogit, kSh, kMeanTime, kShTime};

void store(const Vec4<double>& rotation, const Vec3<double>& log_scale, double log_scale_time,
           const GaussianSpans<float>& to, int64_t n) {
  for (int k = 0; k < 4; ++k) to.at(kRotation, n)[k] = float(rotation[k]);
  for (int k = 0; k < 3; ++k) to.at(kLogScale, n)[k] = float(log_scale[k]);
  *to.at(kLogScaleTime, n) = float(log_scale_time);
}

/// Σ_c = V diag(σ²) Vᵀ, v = b/w, σ_t = √w  [Yang24, Eq. 8].
void to_velocity(const GaussianSpans<const float>& from, const GaussianSpans<float>& to,
                 int64_t n) {
  const Spacetime<double> s = pair_spacetime(
      Vec4<double>(load4(from.at(kRotation, n))), Vec4<double>(load4(from.at(kRotationRight, n))),
      Vec3<double>(load3(from.at(kLogScale, n))), double(*from.at(kLogScaleTime, n)),
      double(*from.at(kMeanTime, n)));
  const Shape3 shape = shape_of(s.covariance);
  store(shape.rotation, shape.log_scale, -0.5 * std::log(s.precision_time), to, n);
  for (int k = 0; k < 3; ++k) to.at(kVelocity, n)[k] = float(s.velocity[k]);
}

/// x = μ + v·σ_t·z_0 + R diag(σ) z, t = μ_t + σ_t·z_0: the columns span the Gaussian of space-time.
void to_pair(const GaussianSpans<const float>& from, const GaussianSpans<float>& to, int64_t n) {
  const Mat3<double> R = rotation_matrix(Vec4<double>(load4(from.at(kRotation, n))));
  const Vec3<double> log_scale(load3(from.at(kLogScale, n)));
  const double life = std::exp(double(*from.at(kLogScaleTime, n)));
  Mat4<double> A{};
  A.m[0][0] = life;
  for (int i = 0; i < 3; ++i) {
    A.m[i + 1][0] = life * double(from.at(kVelocity, n)[i]);
    for (int k = 0; k < 3; ++k) A.m[i + 1][k + 1] = R[k][i] * std::exp(log_scale[k]);
  }
  const Shape4 shape = shape_of(A);
  store(shape.left, glm::log(Vec3<double>(shape.sigma[1], shape.sigma[2], shape.sigma[3])),
        std::log(shape.sigma[0]), to, n);
  for (int k = 0; k < 4; ++k) to.at(kRotationRight, n)[k] = float(shape.right[k]);
}

}  // namespace

GaussianSet in_form(const GaussianSet& dynamic_set, SetForm form) {
  check(is_dynamic(dynamic_set.form()) && is_dynamic(form), "in_form: forms of a dynamic set");
  const GaussianSet sound = select_elements(dynamic_set, valid_elements(dynamic_set));
  if (sound.form() == form) return sound.clone_values();
  GaussianSet result(form, sound.coefficients(), host_memory(), sound.time_levels());
  result.resize(sound.count());
  const GaussianSpans<const float> from = sound.values();
  const GaussianSpans<float> to = result.values();
  for (Group g : kShared) std::copy_n(from.group[g].data, from.group[g].size, to.group[g].data);
  parallel_for(sound.count(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n)
      form == SetForm::kVelocity ? to_velocity(from, to, n) : to_pair(from, to, n);
  });
  return result;
}

GaussianSet plain_velocity_form(const GaussianModel& model) {
  const GaussianSet moving = in_form(model.dynamic_set, SetForm::kVelocity);
  GaussianSet plain(SetForm::kVelocity, moving.coefficients());
  plain.resize(moving.count());
  const GaussianSpans<const float> from = moving.values();
  const GaussianSpans<float> to = plain.values();
  for (int g = 0; g < kGroupCount; ++g)
    if (g != kShTime) std::copy_n(from.group[g].data, from.group[g].size, to.group[g].data);
  const ColourRules<float> colours =
      make_colour_rules<float>(render_options(model), from.coefficients, from.time_levels);
  for (int64_t n = 0; n < from.count; ++n) {
    add_levels(colours, 0.0f, from.at(kShTime, n), to.at(kSh, n));
    if (!(model.drawing.time_filter > 0)) continue;
    const double variance =
        std::exp(2 * double(*from.at(kLogScaleTime, n))) + model.drawing.time_filter;
    *to.at(kLogScaleTime, n) = float(0.5 * std::log(variance));
  }
  return plain;
}

}  // namespace tessera
