// Round Gaussians of one colour, put by hand into a model, for tests of the contribution of each to
// the images of a scene.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "recon4d/evaluation/render.h"
#include "recon4d/reduction/contributions.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {

struct Plain {
  std::array<double, 3> mean{}, colour{0.5, 0.5, 0.5};
  double size = 0.2, opacity = 0.8;
  double mean_time = 0.5, sigma_time = 20;  // dynamic ones
  double speed = 0;                         // along x per clip; of SetForm::kVelocity
};

/// A model without Gaussians that stores `degree` bands.
inline GaussianModel empty_model(SetForm form = SetForm::kPair, int degree = 0) {
  GaussianModel model;
  model.drawing.sh_degree = degree;
  model.static_set = GaussianSet(SetForm::kStatic, sh_coefficients(degree));
  model.dynamic_set = GaussianSet(form, sh_coefficients(degree));
  model.static_set.resize(0);
  model.dynamic_set.resize(0);
  return model;
}

/// A set of these alone, bands zero.
inline GaussianSet plain_set(const GaussianSet& like, const std::vector<Plain>& gaussians) {
  GaussianSet set = like.like();
  set.resize(int64_t(gaussians.size()));
  const GaussianSpans<float> v = set.values();
  for (int g = 0; g < set.groups(); ++g) std::fill_n(v.group[g].data, v.group[g].size, 0.0f);
  for (int64_t n = 0; n < set.count(); ++n) {
    const Plain& plain = gaussians[size_t(n)];
    for (int k = 0; k < 3; ++k) {
      v.at(kMean, n)[k] = float(plain.mean[size_t(k)]);
      v.at(kLogScale, n)[k] = float(std::log(plain.size));
      v.at(kSh, n)[k] = float((plain.colour[size_t(k)] - 0.5) / kSh0);
    }
    v.at(kRotation, n)[0] = 1;
    *v.at(kOpacityLogit, n) = float(std::log(plain.opacity / (1 - plain.opacity)));
    if (set.dim() == 3) continue;
    if (set.form() == SetForm::kPair)
      v.at(kRotationRight, n)[0] = 1;
    else
      v.at(kVelocity, n)[0] = float(plain.speed);
    *v.at(kMeanTime, n) = float(plain.mean_time);
    *v.at(kLogScaleTime, n) = float(std::log(plain.sigma_time));
  }
  return set;
}

inline Contributions contributions_of(const GaussianModel& model, const Scene& scene) {
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  return measure_contributions(*backend, model, sample_training_frames(scene));
}

/// The images of the frames of `sample`, in their order.
inline std::vector<RenderedImage> images_of(const GaussianModel& model, const FrameSample& sample) {
  std::vector<View> views;
  for (const int i : sample.frames)
    views.push_back({sample.scene->frames[size_t(i)].camera, sample.scene->frames[size_t(i)].time});
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  return render_views(*backend, model, views);
}

}  // namespace tessera::testing
