// Small random models, cameras and scenes for the tests of models and their files, made from
// tests/support/test_scene.h.
#pragma once
#include <cstring>
#include <string>

#include "recon4d/evaluation/evaluate.h"
#include "recon4d/evaluation/metrics.h"
#include "tests/support/test_scene.h"

namespace tessera::testing {

inline GaussianSet set_of(const TestGaussians<double>& from) {
  GaussianSet set(from.form, from.coefficients, host_memory(), from.time_levels);
  set.resize(from.count);
  for (int g = 0; g < set.groups(); ++g)
    for (size_t i = 0; i < from.group[g].size(); ++i)
      set.group(Group(g)).value[int64_t(i)] = float(from.group[g][i]);
  return set;
}

inline GaussianModel random_model(int64_t fixed, int64_t moving, uint64_t seed = 7,
                                  int coefficients = 16, SetForm form = SetForm::kPair) {
  Random random(seed);
  GaussianModel model;
  model.static_set =
      set_of(random_gaussians(SetForm::kStatic, fixed, 0.9, 0.12, random, coefficients));
  model.dynamic_set = set_of(random_gaussians(form, moving, 0.9, 0.12, random, coefficients));
  model.drawing.sh_degree = sh_degree_of(coefficients);
  model.time_axis = {12.5, 1.0 / 3};
  model.background = {10, 200, 77};
  model.drawing.near_plane = 0.1;
  model.drawing.far_plane = 123.456;
  return model;
}

/// The same with levels of time in the dynamic set.
inline GaussianModel random_model_in_time(int64_t fixed, int64_t moving, int levels,
                                          uint64_t seed = 7, int coefficients = 16,
                                          SetForm form = SetForm::kPair) {
  GaussianModel model = random_model(fixed, moving, seed, coefficients, form);
  Random random(seed + 1);
  TestGaussians<double> set = random_gaussians(form, moving, 0.9, 0.12, random, coefficients);
  add_time_levels(set, levels, seed + 2);
  model.dynamic_set = set_of(set);
  model.drawing.sh_time_degree = levels;
  return model;
}

inline GaussianModel clone(const GaussianModel& model) {
  GaussianModel copy;
  copy.static_set = model.static_set.clone_values();
  copy.dynamic_set = model.dynamic_set.clone_values();
  copy.drawing = model.drawing;
  copy.time_axis = model.time_axis;
  copy.background = model.background;
  copy.train_scale = model.train_scale;
  copy.prepared_from_source = model.prepared_from_source;
  return copy;
}

/// The model at a timestep as a static one.
inline GaussianModel static_model(const GaussianModel& like, GaussianSet set) {
  GaussianModel model = clone(like);
  model.static_set = std::move(set);
  model.dynamic_set = GaussianSet(SetForm::kPair, like.dynamic_set.coefficients());
  return model;
}

inline bool same_bits(const GaussianSet& a, const GaussianSet& b) {
  if (a.form() != b.form() || a.count() != b.count() || a.coefficients() != b.coefficients() ||
      a.time_levels() != b.time_levels())
    return false;
  for (int g = 0; g < a.groups(); ++g) {
    const Span<const float> x = a.group(Group(g)).value.span(), y = b.group(Group(g)).value.span();
    if (x.size != y.size) return false;
    if (x.size > 0 && std::memcmp(x.data, y.data, size_t(x.size) * sizeof(float)) != 0)
      return false;
  }
  return true;
}

inline bool same_bits(const RenderedImage& a, const RenderedImage& b) {
  return a.rgb.size() == b.rgb.size() && a.alpha.size() == b.alpha.size() &&
         std::memcmp(a.rgb.data(), b.rgb.data(), a.rgb.size() * sizeof(float)) == 0 &&
         std::memcmp(a.alpha.data(), b.alpha.data(), a.alpha.size() * sizeof(float)) == 0;
}

inline RenderedImage render_one(const GaussianModel& model, const View& view) {
  const auto backend = make_cpu_backend();
  return std::move(render_views(*backend, model, {view}).front());
}

/// Two correct images differ by rounding, and where it decides whether α reaches 1/255.
inline void expect_same_image(const RenderedImage& actual, const RenderedImage& expected,
                              double tolerance = 1e-4) {
  constexpr double kCutoffBand = 1.0 / 255 + 1e-4;  // of one faint splat
  constexpr double kCutoffShare = 0.002;            // of the values
  ASSERT_EQ(actual.rgb.size(), expected.rgb.size());
  int64_t beyond = 0;
  double worst = 0;
  for (size_t i = 0; i < actual.rgb.size(); ++i) {
    const double difference = std::abs(double(actual.rgb[i]) - double(expected.rgb[i]));
    ASSERT_TRUE(std::isfinite(difference)) << i;
    beyond += difference > tolerance;
    worst = std::max(worst, difference);
  }
  EXPECT_LE(worst, kCutoffBand);
  EXPECT_LE(double(beyond), kCutoffShare * double(actual.rgb.size())) << "worst " << worst;
}

/// How much an image differs from its background: 0 for an empty one.
inline double coverage(const RenderedImage& image) {
  double sum = 0;
  for (float a : image.alpha) sum += a;
  return sum / double(image.alpha.size());
}

/// Frames of noise seen by `cameras` training cameras at `times` timesteps, plus a held-out camera
/// and, from the first camera, a held-out timestep.
inline Scene noise_scene(int width, int height, uint64_t seed = 3) {
  Random random(seed);
  Scene scene;
  const auto add = [&](const std::string& camera, double angle, double time, Split split) {
    Frame frame;
    frame.name = camera + "/" + std::to_string(scene.frames.size());
    frame.camera_name = camera;
    frame.time = time;
    frame.timestep = int64_t(4 * time);
    frame.split = split;
    frame.camera = look_at({4 * std::sin(angle), 0.4, -4 * std::cos(angle)}, {0, 0, 0}, width,
                           height, 1.2 * width);
    frame.image = {width, height, 3, std::vector<uint8_t>(size_t(3 * width * height))};
    for (uint8_t& byte : frame.image.data) byte = uint8_t(random.below(256));
    scene.frames.push_back(std::move(frame));
  };
  for (double time : {0.0, 1.0})
    for (int c = 0; c < 2; ++c) add("cam0" + std::to_string(c), c, time, Split::kTrain);
  add("cam02", 0.5, 0.0, Split::kTest);   // held-out view
  add("cam00", 0, 0.5, Split::kTest);     // held-out time
  add("cam02", 0.5, 0.25, Split::kTest);  // neither was seen
  return scene;
}

}  // namespace tessera::testing
