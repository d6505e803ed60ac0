// Loss, dL/d image, gradients by splats and by parameters, and the statistic of density control of
// every backend against the CPU oracle in double. The oracle is compared with central differences
// in gradient_test.cpp, so these tests compare each backend with differences at the precision of
// float. Source: failure modes C17, C18.
#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/backends.h"
#include "tests/support/stage_run.h"

namespace tessera::testing {
namespace {

class BackendGradient : public EveryBackend {
 protected:
  void expect_gradients(const TestScene<double>& scene) {
    const Backward<double> expected = backward(scene);
    const Backward<float> actual = backward(scene.as<float>(), backend());
    EXPECT_EQ(actual.bad, 0u);
    ASSERT_EQ(actual.losses.size(), expected.losses.size());
    for (size_t b = 0; b < expected.losses.size(); ++b) {
      // means over pixels of differences of images that agree to 1e-6 on average
      EXPECT_NEAR(actual.losses[b].l1, expected.losses[b].l1, 5e-6);
      EXPECT_NEAR(actual.losses[b].ssim, expected.losses[b].ssim, 2e-5);
      EXPECT_NEAR(actual.losses[b].total, expected.losses[b].total, 1e-5);
    }
    double added = 0;  // what rounding is relative to
    if (scene.moving.count > 0)
      for (const double d : expected.moving.group[kMeanTime]) added += std::abs(d);
    ASSERT_EQ(actual.d_times.size(), expected.d_times.size());
    for (size_t b = 0; b < expected.d_times.size(); ++b)
      EXPECT_NEAR(actual.d_times[b], expected.d_times[b], 1e-4 * added) << "time of view " << b;
    ASSERT_EQ(actual.d_readouts.size(), expected.d_readouts.size());
    for (size_t b = 0; b < expected.d_readouts.size(); ++b)
      EXPECT_NEAR(actual.d_readouts[b], expected.d_readouts[b], 1e-4 * added)
          << "readout of view " << b;
    for (int set = 0; set < 2; ++set) {
      const auto& a = set == 0 ? actual.fixed : actual.moving;
      const auto& e = set == 0 ? expected.fixed : expected.moving;
      for (int g = 0; g < group_count(e.form); ++g)
        expect_group(a.group[g], e.group[g], kGradientBounds, group_name(Group(g), e.form));
      expect_group(actual.statistic[set], expected.statistic[set], kGradientBounds, "statistic");
      // a Gaussian at the edge of an image may be counted as seen or not
      expect_group(actual.seen[set], expected.seen[set], {0, 1, 0.01, 0.01}, "seen");
    }
  }
};
TESSERA_ON_EVERY_BACKEND(BackendGradient);

/// The truth keeps away from the image: no sign of I − G depends on rounding.
TestScene<double> smooth_scene(const SceneCase& c, uint64_t seed) {
  TestScene<double> scene = scene_of(c, seed);
  keep_truth_away(scene, seed + 1);
  return scene;
}

TEST_P(BackendGradient, ParametersEqualTheOracles) {
  // Bugs put back, each seen to fail: R not reduced by the own weight; clamped channels not masked;
  // the mean without the viewing direction; d_opacity 4e-4 off; splat gradients added, not written.
  for (const SceneCase& c : kSceneCases) {
    SCOPED_TRACE(c.name);
    expect_gradients(smooth_scene(c, 21));
  }
}

TEST_P(BackendGradient, OneViewAndFive) {
  // Bug put back: the fifth view left out; seen to fail.
  TestScene<double> scene = random_scene(80, 80, 0.2, 22);
  for (const std::vector<View>& views : {std::vector<View>{three_views()[2]}, five_views()}) {
    SCOPED_TRACE(views.size());
    set_views(scene, views, 23);
    keep_truth_away(scene, 24);
    expect_gradients(scene);
  }
}

TEST_P(BackendGradient, ARollingShutter) {
  for (const SetForm form : kDynamicForms) {
    TestScene<double> scene = random_scene(60, 80, 0.2, 46, form);
    set_readouts(scene, 0.1);
    keep_truth_away(scene, 47);
    expect_gradients(scene);
  }
}

TEST_P(BackendGradient, ImagesAndSetsLargerThanTheBlocksOfAnyStage) {
  TestScene<double> scene = random_scene(700, 900, 0.1, 25);
  std::vector<View> views = three_views();
  for (View& view : views)
    view.camera = view.camera.resized(3 * view.camera.width, 3 * view.camera.height);
  set_views(scene, views, 26);
  keep_truth_away(scene, 27);
  expect_gradients(scene);
}

TEST_P(BackendGradient, WhereTheLightStops) {
  // Bug put back: `index < used` left out; seen to fail.
  TestScene<double> scene = random_scene(100, 100, 0.4, 28);
  for (TestGaussians<double>* set : {&scene.fixed, &scene.moving})
    for (double& logit : set->group[kOpacityLogit]) logit += 4;
  keep_truth_away(scene, 29);
  expect_gradients(scene);
}

TEST_P(BackendGradient, FewerStoredBandsThanDegreeThree) {
  TestScene<double> scene = random_scene(0, 60, 0.2, 30);
  Random random(31);
  scene.fixed = random_gaussians(SetForm::kStatic, 60, 0.9, 0.2, random, 4);
  keep_truth_away(scene, 32);
  expect_gradients(scene);
}

TEST_P(BackendGradient, GaussiansThatOnlySomeViewsSee) {
  // Bug put back: the statistic divided by B instead of n_v; seen to fail.
  TestScene<double> scene = random_scene(200, 200, 0.1, 41);
  for (TestGaussians<double>* set : {&scene.fixed, &scene.moving})
    for (double& x : set->group[kMean]) x *= 2.5;
  keep_truth_away(scene, 42);
  const StageRun<float> run = run_stages(scene.as<float>(), backend());
  int partly = 0, idle = 0;
  for (size_t n = 0; n < 400; ++n) {
    const int64_t views = run.first_of[n + 1] - run.first_of[n];
    partly += views > 0 && views < 3;
    idle += views == 0;
  }
  EXPECT_GT(partly, 100);
  EXPECT_GT(idle, 10);
  expect_gradients(scene);
}

TEST_P(BackendGradient, StatisticsOfAbsoluteGradientsEqualTheOracles) {
  for (const SceneCase& c : kSceneCases)
    for (const bool deterministic : {false, true}) {
      SCOPED_TRACE(std::string(c.name) + (deterministic ? ", deterministic" : ""));
      TestScene<double> scene = smooth_scene(c, 43);
      scene.length_share = deterministic ? 1 : 0.125;
      scene.options.kernels.deterministic = deterministic;
      expect_gradients(scene);
    }
}

TEST_P(BackendGradient, AbsoluteGradientsOfAnyTraversal) {
  // Lists that are cut into segments, and lanes that are pixels of a whole tile.
  TestScene<double> scene = random_scene(700, 900, 0.3, 44);
  scene.length_share = 1;
  keep_truth_away(scene, 45);
  for (const BackwardForm form : {BackwardForm::kSubTile, BackwardForm::kPixel}) {
    scene.options.kernels.backward = form;
    expect_gradients(scene);
  }
}

/// The nine numbers of a splat's gradient, by key, as columns.
template <class Real>
std::map<int64_t, std::array<double, 9>> rows_of(const StageRun<Real>& run) {
  const std::vector<int64_t> keys = run.keys();
  std::map<int64_t, std::array<double, 9>> rows;
  for (size_t s = 0; s < keys.size(); ++s) {
    const SplatGradient<Real>& d = run.d_splats[s];
    rows[keys[s]] = {double(d.mean2d[0]), double(d.mean2d[1]), double(d.conic.xx),
                     double(d.conic.xy),  double(d.conic.yy),  double(d.opacity),
                     double(d.colour[0]), double(d.colour[1]), double(d.colour[2])};
  }
  return rows;
}

TEST_P(BackendGradient, SplatsEqualTheOracles) {
  // Bug put back: d_conic.xy without the half; seen to fail.
  const TestScene<double> scene = random_scene(150, 150, 0.2, 33);
  // the same dL/d image for both
  const auto noise = [](auto& d_colour) {
    Random random(34);
    for (auto& d : d_colour) d = float(random.uniform(-1, 1));
  };
  CpuBackend<double> oracle;
  const auto expected = rows_of(run_stages<double>(scene, oracle, noise));
  const auto actual = rows_of(run_stages<float>(scene.as<float>(), backend(), noise));
  const char* kNames[] = {"mean2d x", "mean2d y", "conic xx", "conic xy", "conic yy",
                          "opacity",  "red",      "green",    "blue"};
  for (size_t k = 0; k < 9; ++k) {
    std::vector<double> a, e;
    for (const auto& [key, row] : expected) {
      const auto found = actual.find(key);
      if (found == actual.end()) continue;
      a.push_back(found->second[k]);
      e.push_back(row[k]);
    }
    EXPECT_GE(a.size() + 1, expected.size());
    expect_group(a, e, kGradientBounds, kNames[k]);
  }
}

/// An image without a renderer: noise, smooth waves and a constant, side by side.
std::vector<double> patterns(const std::vector<View>& views, Random& random) {
  std::vector<double> colour;
  for (const View& view : views)
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < view.camera.height; ++y)
        for (int x = 0; x < view.camera.width; ++x) {
          const int part = (x / 20 + y / 20) % 3;
          const double value = part == 0   ? random.uniform(-0.1, 1.1)
                               : part == 1 ? 0.5 + 0.3 * std::sin(0.2 * x + 0.3 * y + c)
                                           : 0.6013;  // no byte
          colour.push_back(float(value));
        }
  return colour;
}

template <class Real>
std::vector<Real> image_gradient(BackendOf<Real>& backend, const TestScene<double>& scene,
                                 const std::vector<double>& colour, const LossWeights& weights,
                                 std::vector<ViewLoss>& losses) {
  Memory& memory = backend.memory();
  const ViewBatch<Real> batch = make_view_batch<Real>(scene.views);
  const StoredScene<Real> in(scene.as<Real>(), memory);
  Images<Real> images(memory);
  images.colour = stored(std::vector<Real>(colour.begin(), colour.end()), memory);
  Buffer<Real> d_colour(3 * batch.pixels, memory);
  poison(d_colour, memory);
  backend.photometric({&batch, images.colour.span(), in.target().truth, weights, in.target().mask},
                      d_colour.span());
  losses = backend.outcome().losses;
  return fetched(d_colour, memory);
}

TEST_P(BackendGradient, LossAndImageGradientEqualTheOracles) {
  // Bugs put back, each seen to fail: no 1/B; the weight of L1 ignored; the last pixel not written;
  // the partial by E[x²] 0.5 % off.
  TestScene<double> scene;
  std::vector<View> views = five_views();
  views[0].camera = views[0].camera.resized(131, 97);
  set_views(scene, views, 35);
  Random random(36);
  const std::vector<double> colour = patterns(scene.views, random);
  CpuBackend<double> oracle;
  for (const LossWeights& weights : {LossWeights{0.8, 0.2}, {1, 0}, {0, 1}, {0, 1, 1, 0.05}}) {
    SCOPED_TRACE(weights.dssim);
    std::vector<ViewLoss> actual, expected;
    const std::vector<double> e = image_gradient(oracle, scene, colour, weights, expected);
    const std::vector<float> a = image_gradient(backend(), scene, colour, weights, actual);
    ASSERT_EQ(actual.size(), expected.size());
    for (size_t b = 0; b < expected.size(); ++b) {
      EXPECT_NEAR(actual[b].l1, expected[b].l1, 1e-6);
      EXPECT_NEAR(actual[b].ssim, expected[b].ssim, 1e-6);
      EXPECT_NEAR(actual[b].total, expected[b].total, 1e-6);
    }
    // variances are differences of moments of order 1, exact to 1e-7, over (0.03)²; each view's
    // gradient has a scale of its own, the 1 × 1 image's the largest
    size_t first = 0;
    for (const View& view : scene.views) {
      const size_t size = size_t(3 * view.camera.width * view.camera.height);
      const auto part = [&](const auto& all) {
        return std::vector<double>(all.begin() + ptrdiff_t(first),
                                   all.begin() + ptrdiff_t(first + size));
      };
      expect_group(part(a), part(e), {5e-4, 5e-4, 0, 5e-5}, "d_colour");
      first += size;
    }
  }
}

TEST_P(BackendGradient, DeterministicRunsAreEqualToTheBit) {  // C18
  // Bug put back: d_opacity 1e-6 off from run to run; seen to fail.
  TestScene<float> scene = random_scene(900, 900, 0.2, 37).as<float>();
  scene.options.kernels.deterministic = true;
  const Backward<float> a = backward(scene, backend()), b = backward(scene, backend());
  EXPECT_EQ(a.rendered.colour, b.rendered.colour);
  for (int g = 0; g < kGroupCount; ++g) {
    EXPECT_EQ(a.fixed.group[g], b.fixed.group[g]) << group_name(Group(g), SetForm::kStatic);
    EXPECT_EQ(a.moving.group[g], b.moving.group[g]) << group_name(Group(g), SetForm::kPair);
  }
  for (int set = 0; set < 2; ++set) EXPECT_EQ(a.statistic[set], b.statistic[set]);
  for (size_t v = 0; v < a.losses.size(); ++v) EXPECT_EQ(a.losses[v].total, b.losses[v].total);
}

TEST_P(BackendGradient, SpreadOfTheDefaultIsThatOfFloatSums) {  // C18
  // Bug put back: d_opacity 1e-4 off from run to run; seen to fail.
  const TestScene<float> scene = random_scene(900, 900, 0.2, 37).as<float>();
  const Backward<float> first = backward(scene, backend());
  double spread = 0;
  for (int run = 0; run < 4; ++run) {
    const Backward<float> again = backward(scene, backend());
    EXPECT_EQ(again.rendered.colour, first.rendered.colour);  // blending has one order
    for (int g = 0; g < kGroupCount; ++g) {
      spread = std::max(spread, relative(again.fixed.group[g], first.fixed.group[g]));
      spread = std::max(spread, relative(again.moving.group[g], first.moving.group[g]));
    }
  }
  RecordProperty("spread_of_gradients", std::to_string(spread));
  // some hundred addends in another order, of a group whose largest is 1; a quaternion's gradient
  // is a difference of larger terms
  EXPECT_LE(spread, 5e-5);
}

}  // namespace
}  // namespace tessera::testing
