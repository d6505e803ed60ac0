// The gradient of the whole chain (render, L1, D-SSIM, batch of three views) by every parameter of
// static and dynamic Gaussians against central differences in double. Source: failure mode C17.
#include "tests/support/difference.h"

namespace tessera::testing {
namespace {

/// Ten overlapping Gaussians over several tiles; the truth keeps away from the image, so that no
/// |I − G| sits on its kink.
TestScene<double> gradient_scene(uint64_t seed, int degree, bool opaque = false) {
  TestScene<double> scene = random_scene(5, 5, 0.25, seed);
  scene.options.sh_degree = degree;
  if (opaque)  // larger, 1 − α < 1e-2 in the middle: two or three of them stop the light
    for (TestGaussians<double>* set : {&scene.fixed, &scene.moving}) {
      for (double& logit : set->group[kOpacityLogit]) logit += 6;
      for (double& log_scale : set->group[kLogScale]) log_scale += 1;
    }
  keep_truth_away(scene, seed + 100);
  return scene;
}

/// Largest |analytic − difference| over a group, relative to the largest |difference| of the group.
struct GroupError {
  double worst = 0, scale = 0;
  int crossed = 0, compared = 0;
};

GroupError group_error(TestScene<double>& scene, TestGaussians<double>& set,
                       const TestGaussians<double>& gradient, Group group) {
  LossProbe probe(scene);
  const uint64_t decisions = probe.at(scene).decisions;
  GroupError error;
  for (size_t i = 0; i < set.group[group].size(); ++i) {
    const auto expected = difference(probe, scene, set.group[group][i], decisions);
    if (!expected) {
      ++error.crossed;
      continue;
    }
    ++error.compared;
    error.worst = std::max(error.worst, std::abs(gradient.group[group][i] - *expected));
    error.scale = std::max(error.scale, std::abs(*expected));
  }
  return error;
}

/// dL/d a value of each view, which `value` finds in it.
template <class Value>
void expect_of_views(TestScene<double>& scene, const std::vector<double>& analytic,
                     const char* name, double bound, const Value& value) {
  LossProbe probe(scene);
  const uint64_t decisions = probe.at(scene).decisions;
  ASSERT_EQ(analytic.size(), scene.views.size());
  double worst = 0, scale = 0;
  for (size_t b = 0; b < scene.views.size(); ++b) {
    const auto expected = difference(probe, scene, value(scene.views[b]), decisions);
    if (!expected) continue;
    worst = std::max(worst, std::abs(analytic[b] - *expected));
    scale = std::max(scale, std::abs(*expected));
  }
  EXPECT_GT(scale, 1e-6) << name;
  EXPECT_LE(worst, bound * scale) << name;
}

/// dL/d time and dL/d readout of each view. `bound`: of times.
void expect_times(TestScene<double>& scene, const Backward<double>& analytic, double bound = 1e-6) {
  expect_of_views(scene, analytic.d_times, "times", bound,
                  [](View& view) -> double& { return view.time; });
  expect_of_views(scene, analytic.d_readouts, "readouts", 1e-6,
                  [](View& view) -> double& { return view.camera.readout; });
}

// Bugs put back to the times of views, each seen to fail: the sign; the slope of levels of time
// left out; that of the next view.
void expect_differences(TestScene<double> scene, const std::vector<Group>& groups,
                        double bound = 1e-6) {
  const Backward<double> analytic = backward(scene);
  ASSERT_EQ(analytic.bad, 0u);
  if (scene.moving.count > 0) expect_times(scene, analytic, bound);
  for (TestGaussians<double>* const each : {&scene.fixed, &scene.moving}) {
    TestGaussians<double>& set = *each;
    const SetForm form = set.form;
    for (const Group group : groups) {
      if (group >= group_count(form) || set.count == 0) continue;
      const GroupError error = group_error(
          scene, set, form == SetForm::kStatic ? analytic.fixed : analytic.moving, group);
      EXPECT_GT(error.scale, 1e-7) << group_name(group, form);  // the group matters at all
      EXPECT_LE(error.worst, (form == SetForm::kStatic ? 1e-6 : bound) * error.scale)
          << group_name(group, form) << ", " << form_name(form);
      // a scene in which many steps cross a cut-off tests nothing
      EXPECT_LE(error.crossed, error.compared / 20)
          << group_name(group, form) << ", " << form_name(form);
    }
  }
}

const std::vector<Group> kGeometry{kMean,     kLogScale,     kRotation,     kOpacityLogit,
                                   kMeanTime, kLogScaleTime, kRotationRight};

// Bugs put back, each seen to fail: the background left out of R in blend_backward; the opacity's
// gradient without p(t); the mean's without the viewing direction; the SSIM map not convolved.
TEST(Gradient, GeometryEqualsDifferences) {
  expect_differences(gradient_scene(1, 3), kGeometry);
}

TEST(Gradient, GeometryEqualsDifferencesInAnotherScene) {
  expect_differences(gradient_scene(2, 1), kGeometry);
}

// Bug put back: the gradient of the temporal scale without its factor −2; seen to fail.
TEST(Gradient, GeometryOfVelocitiesEqualsDifferences) {
  TestScene<double> scene = gradient_scene(4, 3);
  Random random(51);
  const int64_t count = scene.moving.count;
  scene.moving = random_gaussians(SetForm::kVelocity, count, 0.9, 0.2, random);
  expect_differences(scene, kGeometry);
}

TEST(Gradient, GeometryEqualsDifferencesWhereTheLightStops) {
  // Bug put back: `index < used` left out of blend_backward; seen to fail.
  const TestScene<double> scene = gradient_scene(3, 2, true);
  const Rendered<double> image = render(scene);
  const auto stopped = [](double T) { return T < kMinTransmittance<double>; };
  EXPECT_GT(std::count_if(image.transmittance.begin(), image.transmittance.end(), stopped), 50);
  expect_differences(scene, kGeometry);
}

// Without the 2D filter, whose gradient is not that of its images (filter_test.cpp).
struct Mode {
  const char* name;
  bool filter_3d = false;
  double sigma = kTruncationSigma;
  bool by_falloff = false;
};

class GradientMode : public ::testing::TestWithParam<Mode> {};

// Bugs put back, each seen to fail: the 3D filter's ∂o'/∂s left out; s²/s'² left out of ∂s'/∂s; the
// opacity's gradient by o'(1 − o'); α compared in the backward pass by falloff.
TEST_P(GradientMode, GeometryEqualsDifferences) {
  const Mode& mode = GetParam();
  TestScene<double> scene = random_scene(4, 4, 0.12, 17);
  if (mode.filter_3d) add_filter_3d(scene, 0.12, 8);
  scene.options.truncation_sigma = mode.sigma;
  scene.options.truncation_by_falloff = mode.by_falloff;
  keep_truth_away(scene, 9);
  expect_differences(scene, kGeometry);
}

INSTANTIATE_TEST_SUITE_P(Modes, GradientMode,
                         ::testing::Values(Mode{"filter_3d", true}, Mode{"sigma_2", false, 2},
                                           Mode{"falloff", false, kTruncationSigma, true},
                                           Mode{"together", true, 3, true}),
                         [](const auto& row) { return row.param.name; });

// Bug put back: the filter left out of the backward pass; seen to fail.
TEST(Gradient, WithATimeFilterEqualsDifferences) {
  for (const SetForm form : kDynamicForms) {
    TestScene<double> scene = random_scene(2, 5, 0.2, 19, form);
    scene.options.time_filter = 0.1;
    keep_truth_away(scene, 10);
    expect_differences(scene, kGeometry);
  }
}

// The row of a Gaussian is a constant of its gradient: rows shift by what it moves during the
// readout, a hundredth of the image here.
TEST(Gradient, WithARollingShutterEqualsDifferences) {
  for (const SetForm form : kDynamicForms) {
    TestScene<double> scene = random_scene(2, 5, 0.2, 19, form);
    set_readouts(scene, 0.01);
    keep_truth_away(scene, 10);
    expect_differences(scene, kGeometry, 0.01);
  }
}

// Bugs put back, each seen to fail: the slope left out of the mean time's gradient, or its sign
// turned, or its n left out; weights left out of the levels' gradient; the direction's gradient by
// the first level alone.
TEST(Gradient, WithLevelsOfTimeEqualsDifferences) {
  for (const SetForm form : kDynamicForms)
    for (const bool sliced : {true, false}) {
      TestScene<double> scene = random_scene(0, 0, 0.25, 23);
      Random random(sliced ? 24 : 25);
      scene.moving = random_gaussians(form, 4, 0.9, 0.25, random, sliced ? 9 : 4);
      add_time_levels(scene.moving, sliced ? 2 : 1, 26);
      scene.options.sh_time_period = 0.9;
      scene.options.sliced_direction = sliced;
      keep_truth_away(scene, 27);
      expect_differences(scene, {kMean, kMeanTime, kSh, kShTime});
    }
}

class GradientSh : public ::testing::TestWithParam<int> {};

TEST_P(GradientSh, CoefficientsEqualDifferences) {
  expect_differences(gradient_scene(3, GetParam()), {kSh});
}

INSTANTIATE_TEST_SUITE_P(Degrees, GradientSh, ::testing::Values(0, 1, 2, 3));

/// Every pixel with an odd sum of coordinates, and the left third, is ignored.
std::vector<std::vector<uint8_t>> chequered(const std::vector<View>& views) {
  std::vector<std::vector<uint8_t>> masks;
  for (const View& view : views) {
    const int width = view.camera.width, height = view.camera.height;
    masks.emplace_back();
    for (int i = 0; i < width * height; ++i)
      masks.back().push_back((i % width + i / width) % 2 == 1 || i % width < width / 3 ? 0 : 255);
  }
  return masks;
}

// B17. With L1 alone: in the windows of SSIM ignored pixels are constants to the gradient, which a
// difference of the whole chain is not (ssim_test.cpp has that case by pixels).
// Bug put back: inverted polarity in the gradient alone; seen to fail.
TEST(Gradient, WithMasksEqualsDifferences) {
  TestScene<double> scene = gradient_scene(1, 3);
  scene.mask = chequered(scene.views);
  scene.weights = {1, 0};
  expect_differences(scene, {kMean, kOpacityLogit, kMeanTime});
}

// Bug put back: the weight left out of the gradient; seen to fail.
TEST(Gradient, WithMoreWeightOnMovingPixelsEqualsDifferences) {
  TestScene<double> scene = gradient_scene(1, 3);
  scene.mask = chequered(scene.views);
  for (std::vector<uint8_t>& mask : scene.mask)
    for (uint8_t& pixel : mask) pixel = pixel == 0 ? uint8_t{1} : kMovingPixel;
  const double plain = backward(scene).losses[0].l1;
  scene.weights.moving = 4;
  EXPECT_GT(backward(scene).losses[0].l1, 1.5 * plain);
  expect_differences(scene, {kMean, kOpacityLogit, kMeanTime});
}

TEST(Gradient, InactiveBandsHaveNone) {
  const Backward<double> analytic = backward(gradient_scene(4, 1));
  for (int64_t n = 0; n < analytic.fixed.count; ++n)
    for (int i = 3 * sh_coefficients(1); i < 48; ++i) EXPECT_EQ(analytic.fixed.at(kSh, n)[i], 0.0);
}

TEST(Gradient, GaussianOutsideEveryViewHasNone) {
  TestScene<double> scene = gradient_scene(5, 3);
  scene.fixed.at(kMean, 2)[1] = 500;
  *scene.moving.at(kMeanTime, 3) = 40;
  const Backward<double> analytic = backward(scene);
  const auto expect_zero = [](const TestGaussians<double>& set, int64_t n) {
    for (int g = 0; g < group_count(set.form); ++g)
      for (int i = 0; i < group_width(Group(g), set.coefficients, set.form); ++i)
        EXPECT_EQ(set.at(Group(g), n)[i], 0.0) << group_name(Group(g), set.form);
  };
  expect_zero(analytic.fixed, 2);
  expect_zero(analytic.moving, 3);
  EXPECT_EQ(analytic.seen[0][2], 0.0);
  EXPECT_EQ(analytic.seen[1][3], 0.0);
}

/// Float against double through the same chain, as a share of the largest gradient of the group.
TEST(Gradient, FloatIsNearDouble) {
  const TestScene<double> scene = gradient_scene(1, 3);
  const Backward<double> exact = backward(scene);
  const Backward<float> rough = backward(scene.as<float>());
  for (int g = 0; g < kGroupCount; ++g) {
    double scale = 0, worst = 0;
    for (size_t i = 0; i < exact.moving.group[g].size(); ++i) {
      scale = std::max(scale, std::abs(exact.moving.group[g][i]));
      worst = std::max(worst, std::abs(exact.moving.group[g][i] - rough.moving.group[g][i]));
    }
    // sums of some 1000 pixels whose terms are exact to 1e-6 and partly cancel
    EXPECT_LE(worst, 2e-4 * scale) << group_name(Group(g), SetForm::kPair);
  }
}

}  // namespace
}  // namespace tessera::testing
