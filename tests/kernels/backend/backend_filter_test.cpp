// Anti-aliasing filters and non-default truncations on every backend against the CPU oracle in
// double: images, gradients, opacity 0, and sizes and edits of the 3D filter. The oracle is tested
// in brute_force_test.cpp, gradient_test.cpp and filter_test.cpp.
#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/backends.h"
#include "tests/support/stage_run.h"

namespace tessera::testing {
namespace {

struct Mode {
  const char* name;
  bool filter_2d = false, filter_3d = false;
  double sigma = kTruncationSigma;
  bool by_falloff = false;
};

const Mode kModes[] = {{"2D filter", true},
                       {"3D filter", false, true},
                       {"4 sigma", false, false, 4},
                       {"2 sigma", false, false, 2},
                       {"by falloff", false, false, kTruncationSigma, true},
                       {"by falloff, 1 sigma", false, false, 1, true},
                       {"together", true, true, 3, true}};

TestScene<double> scene_of(const Mode& mode, uint64_t seed) {
  TestScene<double> scene = random_scene(120, 120, 0.12, seed);
  scene.options.filter_2d = mode.filter_2d;
  if (mode.filter_3d) add_filter_3d(scene, 0.12, seed + 1);
  scene.options.truncation_sigma = mode.sigma;
  scene.options.truncation_by_falloff = mode.by_falloff;
  keep_truth_away(scene, seed + 2);
  return scene;
}

class BackendFilter : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendFilter);

/// Pixels where no α, nor T, comes near its cut-off.
double worst_elsewhere(const Rendered<float>& actual, const Rendered<double>& expected,
                       const std::vector<std::vector<bool>>& critical, double& marked) {
  double worst = 0, all = 0;
  size_t first = 0;
  marked = 0;
  for (const std::vector<bool>& mask : critical) {
    for (size_t p = 0; p < mask.size(); ++p) {
      ++all;
      marked += mask[p];
      for (size_t c = 0; c < 3 && !mask[p]; ++c) {
        const size_t i = 3 * first + c * mask.size() + p;
        worst = std::max(worst, std::abs(double(actual.colour[i]) - expected.colour[i]));
      }
    }
    first += mask.size();
  }
  marked /= all;
  return worst;
}

TEST_P(BackendFilter, ImagesEqualTheOracles) {
  // Bugs put back, each seen to fail: the default cut-off in blend; comp left out; φ ignored.
  for (const Mode& mode : kModes) {
    SCOPED_TRACE(mode.name);
    const TestScene<double> scene = scene_of(mode, 51);
    const Rendered<float> actual = render(scene.as<float>(), backend());
    const Rendered<double> expected = render(scene);
    double marked = 0;
    EXPECT_LE(worst_elsewhere(actual, expected, critical_pixels(scene), marked),
              kPictureBounds.element);
    EXPECT_LE(marked, 0.08);  // by falloff every splat has an edge in every view
  }
}

TEST_P(BackendFilter, GradientsEqualTheOraclesInEveryForm) {
  // Bugs put back, each seen to fail: the default cut-off in blend_backward; the opacity's gradient
  // by o'(1 − o').
  for (const Mode& mode : kModes)
    for (const BackwardForm form : {BackwardForm::kSubTile, BackwardForm::kPixel}) {
      if (!is_cuda() && form != BackwardForm::kSubTile) continue;  // the CPU has one way
      SCOPED_TRACE(std::string(mode.name) + ", form " + std::to_string(int(form)));
      TestScene<double> scene = scene_of(mode, 54);
      scene.options.kernels.backward = form;
      const Backward<double> expected = backward(scene);
      const Backward<float> actual = backward(scene.as<float>(), backend());
      EXPECT_EQ(actual.bad, 0u);
      // at an edge of high contrast one pixel more or less is a larger share of a small splat
      GroupBounds bounds = kGradientBounds;
      if (mode.sigma < 3.3) {
        bounds.outlier = 0.2;
        bounds.bias = 2e-3;
        bounds.budget = 0.02;
      }
      for (int g = 0; g < kGroupCount; ++g) {
        expect_group(actual.moving.group[g], expected.moving.group[g], bounds,
                     group_name(Group(g), SetForm::kPair));
        if (g < kStaticGroups)
          expect_group(actual.fixed.group[g], expected.fixed.group[g], bounds,
                       group_name(Group(g), SetForm::kStatic));
      }
    }
}

TEST_P(BackendFilter, ByFalloffOpacityZeroHasAFiniteGradient) {
  // Bug put back: opacity 0 culled; seen to fail.
  for (const double logit : {-80.0, -1000.0}) {
    TestScene<double> scene = random_scene(40, 40, 0.2, 57);
    for (TestGaussians<double>* set : {&scene.fixed, &scene.moving})
      std::fill(set->group[kOpacityLogit].begin(), set->group[kOpacityLogit].end(), logit);
    scene.options.truncation_by_falloff = true;
    const Backward<float> result = backward(scene.as<float>(), backend());
    EXPECT_EQ(result.bad, 0u);
    EXPECT_GT(result.rendered.report.splats, 100);
    for (const TestGaussians<float>* set : {&result.fixed, &result.moving})
      for (int g = 0; g < group_count(set->form); ++g)
        for (const float d : set->group[g]) ASSERT_TRUE(std::isfinite(d)) << logit;
  }
}

TEST_P(BackendFilter, SizesEqualTheOracles) {
  // Bugs put back, each seen to fail: the last view left out; the unseen left at −1; the temporal
  // filter left out.
  for (const SetForm form : kForms) {
    Random random(58);
    TestGaussians<double> set = random_gaussians(form, 3000, 2.5, 0.1, random);
    for (double& x : set.group[kLogScaleTime]) x -= 1;
    const auto measured = [&](auto& on, const auto& gaussians) {
      using Real = std::decay_t<decltype(gaussians.group[0][0])>;
      const ViewBatch<Real> views = make_view_batch<Real>(three_views());
      const StoredGaussians<Real> in(gaussians, on.memory());
      Buffer<Real> sizes(gaussians.count, on.memory());
      poison(sizes, on.memory());
      on.filter_sizes({&views, in.view(), Real(0.2), Real(50), Real(0.01)}, sizes.span());
      return fetched(sizes, on.memory());
    };
    CpuBackend<double> oracle;
    const std::vector<double> expected = measured(oracle, set);
    const std::vector<float> actual = measured(backend(), set.as<float>());
    EXPECT_GT(std::count(expected.begin(), expected.end(),
                         *std::max_element(expected.begin(), expected.end())),
              5);
    // a mean at the margin of an image may be sampled or not
    expect_group(actual, expected, {1e-5, 1, 0.003, 1e-3}, "size");
  }
}

TEST_P(BackendFilter, EditsAreTheOracles) {
  // Bugs put back, each seen to fail: the last Gaussian left out; scales before the opacity.
  for (const FilterEdit edit :
       {FilterEdit::kRaiseScales, FilterEdit::kBake, FilterEdit::kLimitOpacity})
    for (const SetForm form : kForms) {
      TestScene<double> scene =
          random_scene(form == SetForm::kStatic ? 1000 : 0, form == SetForm::kStatic ? 0 : 1000,
                       0.1, 59, form == SetForm::kStatic ? SetForm::kPair : form);
      add_filter_3d(scene, 0.1, 60);
      TestGaussians<double>& set = form == SetForm::kStatic ? scene.fixed : scene.moving;
      StoredGaussians<float> stored(set.as<float>(), memory());
      backend().edit_by_filter(edit, stored.spans(), 0.01f);
      const TestGaussians<float> actual = stored.fetch();
      CpuBackend<double> oracle;
      oracle.edit_by_filter(edit, set.spans(), 0.01);
      for (int g = 0; g < group_count(set.form); ++g)
        expect_group(actual.group[g], set.group[g], {2e-6, 2e-6, 0, 1e-5},
                     group_name(Group(g), form));
    }
}

}  // namespace
}  // namespace tessera::testing
