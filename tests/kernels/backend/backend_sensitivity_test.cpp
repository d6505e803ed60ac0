// Measures of splats on every backend: the change of the squared error against images from which a
// splat is removed, weights that add up to the opacity of the pixel, images by weight, the
// equations of the gradient, and the residual. The reference is the oracle, which is compared with
// the removal of Gaussians.
#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/backends.h"
#include "tests/support/front_scene.h"
#include "tests/support/stage_run.h"

namespace tessera::testing {
namespace {

template <class Real>
struct Sensed {
  std::vector<SplatSensitivity<Real>> splat;
  std::vector<SplatGradient<Real>> gradient;  // by the same image, of Σ x·colour
  StageRun<Real> run;
  std::vector<Real> image;  // x: the residual, but for `edit`
};

/// The measures of a scene's splats; the output of a stage is poisoned first.
template <class Real>
Sensed<Real> sense(const TestScene<Real>& scene, BackendOf<Real>& backend,
                   const EditImageGradient<Real>& edit = {}) {
  Memory& memory = backend.memory();
  const StoredScene<Real> in(scene, memory);
  Sensed<Real> out;
  out.run.batch = make_view_batch<Real>(scene.views);
  const ViewBatch<Real>& batch = out.run.batch;
  Splats<Real> splats(memory);
  TileInstances<Real> instances(memory);
  Images<Real> images(memory);
  backend.project({&batch, {in.sets[0].view(), in.sets[1].view()}, scene.options, true}, splats);
  backend.bin({&batch, &splats, scene.options, true}, instances);
  const BlendArgs<Real> blend{&batch, &splats, &instances, scene.options, true};
  backend.blend(blend, images);
  if (in.environment_height > 0) {
    EnvironmentArgs<Real> environment = in.forward(true).environment;
    environment.batch = &batch;
    backend.environment(environment, images);
  }
  const Target target = in.target();
  Buffer<Real> image(3 * batch.pixels, memory);
  poison(image, memory);
  Buffer<Real> mapped(memory);
  const Span<const Real> colour = std::as_const(images.colour).span();
  backend.residual({&batch, compared_images(backend, batch, target, colour, mapped), target.truth,
                    target.weights, target.mask},
                   image.span());
  out.image = fetched(image, memory);
  if (edit) {
    edit(out.image);
    store_over(out.image, image.span(), memory);
  }
  const BlendBackwardArgs<Real> pass{blend, &images, image.span()};
  Buffer<SplatSensitivity<Real>> sums(splats.count, memory);
  poison(sums, memory);
  std::vector<Vec3<double>> response;
  for (const ColourMap<double>& map : target.maps) response.push_back(channel_response(map));
  backend.sensitivity({pass, target.mask, response}, sums.span());
  Buffer<SplatMoments<Real>> gradient(splats.count, memory);
  backend.blend_backward(pass, gradient.span());
  fetch_lists(splats, instances, memory, out.run);
  out.gradient = gradients_of(out.run.splat, fetched(gradient, memory));
  out.splat = fetched(sums, memory);
  out.run.colour = fetched(images.colour, memory);
  out.run.transmittance = fetched(images.transmittance, memory);
  return out;
}

template <class Real>
Sensed<Real> sense(const TestScene<Real>& scene) {
  CpuBackend<Real> backend;
  return sense(scene, backend);
}

double total(const std::vector<double>& image) {
  double sum = 0;
  for (const double x : image) sum += x * x;
  return sum;
}

constexpr int kTerms = 8;

/// A term of every splat, in the order of SplatSensitivity.
template <class Real>
std::vector<double> term(const Sensed<Real>& sensed, int k) {
  std::vector<double> values;
  for (const SplatSensitivity<Real>& s : sensed.splat)
    values.push_back(double(k == 0   ? s.weight
                            : k == 1 ? s.weight2
                            : k < 5  ? s.image[k - 2]
                            : k == 5 ? s.removal1
                            : k == 6 ? s.removal2
                                     : s.moving));
  return values;
}

/// A scene whose light stops nowhere, so that taking a Gaussian out changes what was drawn alone.
TestScene<double> translucent_scene(uint64_t seed) {
  TestScene<double> scene = random_scene(20, 20, 0.25, seed);
  for (TestGaussians<double>* set : {&scene.fixed, &scene.moving})
    for (double& logit : set->group[kOpacityLogit]) logit -= 1;
  return scene;
}

void add_masks_and_gains(TestScene<double>& scene, uint64_t seed) {
  Random random(seed);
  for (size_t b = 0; b < scene.views.size(); ++b) {
    scene.maps.push_back(colour_gain<double>(
        {random.uniform(0.7, 1.3), random.uniform(0.7, 1.3), random.uniform(0.7, 1.3)}));
    scene.mask.emplace_back();
    const size_t width = size_t(scene.views[b].camera.width);
    for (size_t p = 0; p < scene.truth[b].size() / 3 && b != 1; ++p)
      scene.mask.back().push_back(uint8_t((p % width / 5 + p / width / 3 + b) % 4));
  }
}

void add_environment(TestScene<double>& scene) {
  std::fill_n(scene.options.background, 3, 0.0);
  scene.environment_height = 8;
  for (int i = 0; i < 3 * 8 * 16; ++i) scene.environment.push_back(0.5 + 0.3 * std::sin(0.1 * i));
}

/// Takes every Gaussian out of a scene in turn and compares Σ x² with what its splats promised.
void expect_promises_kept(const TestScene<double>& scene) {
  const Sensed<double> sensed = sense(scene);
  for (const double T : sensed.run.transmittance) ASSERT_GT(T, 1e-4);
  const double whole = total(sensed.image);
  int moved = 0;
  for (int64_t n = 0; n < scene.fixed.count + scene.moving.count; ++n) {
    double promised = 0, size = 0;
    for (int64_t s = sensed.run.first_of[size_t(n)]; s < sensed.run.first_of[size_t(n) + 1]; ++s) {
      const SplatSensitivity<double>& splat = sensed.splat[size_t(s)];
      promised += splat.removal1 + splat.removal2;
      size += std::abs(splat.removal1) + splat.removal2;
    }
    TestScene<double> without = scene;
    *(n < scene.fixed.count ? without.fixed.at(kOpacityLogit, n)
                            : without.moving.at(kOpacityLogit, n - scene.fixed.count)) = -40;
    const double change = total(sense(without).image) - whole;
    EXPECT_NEAR(promised, change, 1e-9 * size + 1e-12 * whole) << n;
    moved += std::abs(change) > 1e-3;
  }
  EXPECT_GT(moved, 30);
}

// Bugs put back, each seen to fail: the own weight left in Q; the background left out of Q; one
// channel's change not squared; 1 − α in the place of its inverse.
TEST(Sensitivity, TheErrorChangesAsPromisedWhereAGaussianIsTakenOut) {
  expect_promises_kept(translucent_scene(1));
}

// Bugs put back, each seen to fail: masks left out of the second order; the gain left out; gains of
// the next view.
TEST(Sensitivity, TheErrorChangesAsPromisedWithMasksAndGains) {
  TestScene<double> scene = translucent_scene(2);
  add_masks_and_gains(scene, 3);
  expect_promises_kept(scene);
}

// Bug put back: the own weight left in Q; seen to fail.
TEST(Sensitivity, TheErrorChangesAsPromisedBeforeAnEnvironment) {
  TestScene<double> scene = translucent_scene(4);
  add_environment(scene);
  expect_promises_kept(scene);
}

class BackendSensitivity : public EveryBackend {
 protected:
  void expect_the_oracles(const TestScene<double>& scene) {
    const Sensed<double> expected = sense(scene);
    const Sensed<float> actual = sense(scene.as<float>(), backend());
    ASSERT_EQ(actual.run.keys(), expected.run.keys());
    const char* const names[kTerms] = {"weight", "weight²", "red",    "green",
                                       "blue",   "first",   "second", "moving"};
    for (int k = 0; k < kTerms; ++k)
      expect_group(term(actual, k), term(expected, k), kGradientBounds, names[k]);
  }
};
TESSERA_ON_EVERY_BACKEND(BackendSensitivity);

// For a device's kernels; the oracle is the CPU's code, which the tests above test.
// Bugs put back, each seen to fail on the CPU: sums that begin where those of the last call ended;
// masks of the next view in the residual.
TEST_P(BackendSensitivity, EqualsTheOracles) {
  for (const SceneCase& c : kSceneCases) {
    SCOPED_TRACE(c.name);
    TestScene<double> scene = scene_of(c, 71);
    if (c.degree == 3) add_masks_and_gains(scene, 72);
    expect_the_oracles(scene);
  }
}

TEST_P(BackendSensitivity, EqualsTheOraclesInFiveViewsOfManyTiles) {
  TestScene<double> scene = random_scene(300, 300, 0.15, 73);
  std::vector<View> views = five_views();
  for (View& view : views)
    view.camera = view.camera.resized(3 * view.camera.width, 3 * view.camera.height);
  set_views(scene, views, 74);
  add_masks_and_gains(scene, 75);
  expect_the_oracles(scene);
  add_environment(scene);
  expect_the_oracles(scene);
}

TEST_P(BackendSensitivity, EqualsTheOraclesWhereTheLightStops) {
  TestScene<double> scene = random_scene(100, 100, 0.4, 76);
  for (TestGaussians<double>* set : {&scene.fixed, &scene.moving})
    for (double& logit : set->group[kOpacityLogit]) logit += 4;
  expect_the_oracles(scene);
}

TEST_P(BackendSensitivity, NoSwitchChangesIt) {
  TestScene<double> scene = random_scene(150, 150, 0.25, 77);
  for (const BackwardForm form : {BackwardForm::kSubTile, BackwardForm::kPixel})
    for (const bool deterministic : {false, true}) {
      SCOPED_TRACE(int(form) * 2 + deterministic);
      scene.options.kernels.backward = form;
      scene.options.kernels.deterministic = deterministic;
      expect_the_oracles(scene);
    }
}

// Bugs put back, each seen to fail on the CPU: T not reduced behind a splat that it passes;
// `index < used` left out.
TEST_P(BackendSensitivity, WeightsAndLightThatIsLeftAddUpToPixels) {
  const Sensed<float> sensed = sense(random_scene(150, 150, 0.2, 78).as<float>(), backend());
  double sum = 0;
  for (const double w : term(sensed, 0)) sum += w;
  EXPECT_GT(sum, 100);
  for (const float T : sensed.run.transmittance) sum += double(T);
  EXPECT_NEAR(sum, double(sensed.run.batch.pixels), 1e-6 * double(sensed.run.batch.pixels));
}

// A pixel that moves counts with all splats over it, one that does not with none, and without a
// mask all may move. Bugs put back, each seen to fail on the CPU: all that count move; without a
// mask none does; none that may; the mask of the next view.
TEST_P(BackendSensitivity, LightInMovingPixelsIsThatOfWhatIsThere) {
  TestScene<double> scene = random_scene(150, 150, 0.2, 88);
  set_views(scene, five_views(), 89);
  add_masks_and_gains(scene, 90);  // of all views but the second
  const Sensed<float> sensed = sense(scene.as<float>(), backend());
  std::vector<double> moving(scene.views.size(), 0), expected = moving;
  int lit = 0;
  for (size_t s = 0; s < sensed.splat.size(); ++s)
    moving[size_t(sensed.run.splat[s].view)] += double(sensed.splat[s].moving);
  for (size_t b = 0; b < scene.views.size(); ++b) {
    const int64_t first = sensed.run.batch.views[b].first_pixel;
    for (size_t p = 0; p < scene.truth[b].size() / 3; ++p)
      if (scene.mask[b].empty() || scene.mask[b][p] >= kMovingPixel)
        expected[b] += 1 - double(sensed.run.transmittance[size_t(first) + p]);
    lit += expected[b] > 10;
    EXPECT_NEAR(moving[b], expected[b], 1e-5 * expected[b]) << b;
  }
  EXPECT_EQ(lit, 4) << "the last view looks elsewhere";
}

// Masks and gains are in the change of the error alone.
// Bug put back: gains in the image; seen to fail on the CPU.
TEST_P(BackendSensitivity, ImageOfOnesGivesTheWeight) {
  TestScene<double> scene = random_scene(100, 100, 0.2, 79);
  add_masks_and_gains(scene, 80);
  const Sensed<float> sensed =
      sense<float>(scene.as<float>(), backend(),
                   [](std::vector<float>& image) { std::fill(image.begin(), image.end(), 1.0f); });
  for (const SplatSensitivity<float>& s : sensed.splat)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(s.image[c], s.weight, 1e-6 * s.weight);
}

// dC/dc = w and ΔC = −α·dC/dα: two ways to the same numbers.
// Bugs put back, each seen to fail on the CPU: red read for green; the own weight left in Q; the
// first order without its 2.
TEST_P(BackendSensitivity, AgreesWithTheGradientByTheSameImage) {
  TestScene<double> scene = random_scene(150, 150, 0.2, 81);
  set_views(scene, five_views(), 82);
  const Sensed<float> sensed = sense(scene.as<float>(), backend());
  std::vector<double> first;
  std::vector<std::vector<double>> colour(3);
  for (size_t s = 0; s < sensed.splat.size(); ++s) {
    first.push_back(-2.0 * sensed.run.splat[s].opacity * sensed.gradient[s].opacity);
    for (int c = 0; c < 3; ++c) colour[size_t(c)].push_back(sensed.gradient[s].colour[c]);
  }
  // the same pixels, decided alike; each sums some hundred terms in its own order
  constexpr GroupBounds kRounding{2e-5, 2e-5, 0, 2e-5};
  expect_group(term(sensed, 5), first, kRounding, "first order");
  for (int c = 0; c < 3; ++c)
    expect_group(term(sensed, 2 + c), colour[size_t(c)], kRounding, "colour");
}

// Bugs put back, each seen to fail on the CPU: the mask's polarity; the mask of the next view;
// gains of the next view; the truth read plane by plane.
TEST_P(BackendSensitivity, ResidualIsTheImageLessItsTruth) {
  TestScene<double> scene = large_scene(83);
  for (const bool plain : {true, false}) {
    SCOPED_TRACE(plain);
    if (!plain) add_masks_and_gains(scene, 84);
    const Sensed<float> sensed = sense(scene.as<float>(), backend());
    ASSERT_EQ(sensed.image.size(), sensed.run.colour.size());
    int64_t ignored = 0;
    for (size_t b = 0; b < scene.views.size(); ++b) {
      const size_t pixels = scene.truth[b].size() / 3;
      const size_t first = 3 * size_t(sensed.run.batch.views[b].first_pixel);
      for (size_t i = 0; i < 3 * pixels; ++i) {
        const size_t p = i % pixels, c = i / pixels;
        const bool counts = plain || scene.mask[b].empty() || scene.mask[b][p] != 0;
        const double gain = plain ? 1 : channel_response(scene.maps[b])[int(c)];
        const double miss =
            gain * double(sensed.run.colour[first + i]) - scene.truth[b][3 * p + c] / 255.0;
        if (counts)
          EXPECT_NEAR(sensed.image[first + i], miss, 1e-6);
        else
          EXPECT_EQ(sensed.image[first + i], 0.0f);
        ignored += !counts;
      }
    }
    EXPECT_EQ(ignored > 1000, !plain);
  }
}

// Bug put back: lists walked to their end, beyond `used`; seen to fail on the CPU.
TEST_P(BackendSensitivity, WhatIsHiddenIsNothing) {
  TestScene<float> scene = front_scene();
  add_round(scene, {0, 0, 5}, 200, 1 - 1e-5, {0.8, 0.4, 0.2});
  add_round(scene, {0, 0, 8}, 0.1, 0.9, {0.1, 0.9, 0.5});
  const Sensed<float> sensed = sense(scene, backend());
  ASSERT_EQ(sensed.splat.size(), 2u);
  EXPECT_GT(sensed.splat[0].removal2, 100);
  for (int k = 0; k < kTerms; ++k) EXPECT_EQ(term(sensed, k)[1], 0) << k;
  scene.fixed = scene.fixed.select({1});  // alone it is something
  const Sensed<float> alone = sense(scene, backend());
  ASSERT_EQ(alone.splat.size(), 1u);
  EXPECT_GT(alone.splat[0].removal2, 0.1f);
}

// Bug put back: bytes divided by 256; seen to fail on the CPU.
TEST_P(BackendSensitivity, WithoutGaussiansThereIsAResidualAlone) {
  TestScene<float> scene = front_scene();
  scene.options.background[1] = 0.5;
  const Sensed<float> sensed = sense(scene, backend());
  EXPECT_TRUE(sensed.splat.empty());
  for (size_t i = 0; i < sensed.image.size(); ++i)
    EXPECT_NEAR(sensed.image[i], (i / (kFrontSize * kFrontSize) == 1 ? 0.5 : 0) - 77 / 255.0, 1e-6);
}

// On a device with the switch. Bug put back: sums that begin where those of the last call ended;
// seen to fail on the CPU.
TEST_P(BackendSensitivity, EqualInputsGiveEqualBits) {
  TestScene<float> scene = random_scene(400, 400, 0.2, 85).as<float>();
  scene.options.kernels.deterministic = true;
  const Sensed<float> one = sense(scene, backend()), other = sense(scene, backend());
  for (int k = 0; k < kTerms; ++k) EXPECT_EQ(term(one, k), term(other, k)) << k;
}

// The pipeline does what the stages did here, with the masks and gains of its last residual.
// Bug put back: the pipeline drops masks; seen to fail on the CPU.
TEST_P(BackendSensitivity, OfThePipelineIsThatOfTheStages) {
  TestScene<double> scene = random_scene(60, 60, 0.2, 86);
  add_masks_and_gains(scene, 87);
  scene.options.kernels.deterministic = true;
  const Sensed<float> stages = sense(scene.as<float>(), backend());
  const StoredScene<float> in(scene.as<float>(), memory());
  Pipeline<float> pipeline(backend());
  pipeline.forward(in.forward(true));
  pipeline.residual(in.target());
  EXPECT_EQ(fetched(pipeline.d_colour(), memory()), stages.image);
  Sensed<float> sensed;
  sensed.splat = fetched(pipeline.sensitivity(), memory());
  for (int k = 0; k < kTerms; ++k) EXPECT_EQ(term(sensed, k), term(stages, k)) << k;
  pipeline.forward(in.forward(false));
  EXPECT_ANY_THROW(pipeline.sensitivity());
}

}  // namespace
}  // namespace tessera::testing
