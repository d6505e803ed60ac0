// The largest blending weight of every Gaussian on every backend, against images in which one
// Gaussian is white and all others and the background are black: such an image holds the weights of
// that Gaussian.
#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/backends.h"
#include "tests/support/stage_run.h"
#include "tests/support/stored_scene.h"

namespace tessera::testing {
namespace {

/// A weight differs by the roundings of the alphas in front of it, or by a splat at its cut-off.
constexpr double kTolerance = 1e-5;

class BackendLargestWeight : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendLargestWeight);

void paint(TestGaussians<double>& set, int64_t n, double value) {
  for (int c = 0; c < 3; ++c) set.at(kSh, n)[c] = value;
}

/// Of Gaussian n of the whole scene, static set first, over all its views.
double largest_weight(TestScene<double> scene, int64_t n) {
  constexpr double kWhite = 0.5 / 0.28209479177387814, kBlack = -kWhite;
  scene.options.sh_degree = 0;
  std::fill_n(scene.options.background, 3, 0.0);
  for (int64_t i = 0; i < scene.fixed.count; ++i) paint(scene.fixed, i, i == n ? kWhite : kBlack);
  for (int64_t i = 0; i < scene.moving.count; ++i)
    paint(scene.moving, i, i + scene.fixed.count == n ? kWhite : kBlack);
  CpuBackend<double> backend;
  const std::vector<double> colour = render(scene, backend).colour;
  return *std::max_element(colour.begin(), colour.end());
}

std::vector<float> weights_of(const TestScene<float>& scene, Backend& backend,
                              const std::vector<float>& before) {
  const StoredScene<float> in(scene, backend.memory());
  Pipeline<float> pipeline(backend);
  pipeline.forward(in.forward(true));
  Buffer<float> elements = stored(before, backend.memory());
  pipeline.add_largest_weights(elements.span());
  return fetched(elements, backend.memory());
}

// Bugs put back: the sum of weights for their maximum; transmittance that is not reduced; numbers
// of splats for those of Gaussians. Each seen to fail on the CPU.
TEST_P(BackendLargestWeight, IsThatOfAWhiteGaussianAmongBlackOnes) {
  for (const SceneCase& c : kSceneCases) {
    const TestScene<double> scene = scene_of(c, 91);
    const int64_t count = scene.fixed.count + scene.moving.count;
    const std::vector<float> actual =
        weights_of(scene.as<float>(), backend(), std::vector<float>(size_t(count), 0.0f));
    int64_t seen = 0;
    for (int64_t n = 0; n < count; n += std::max<int64_t>(1, count / 40)) {
      const double expected = largest_weight(scene, n);
      EXPECT_NEAR(actual[size_t(n)], expected, kTolerance) << c.name << ", Gaussian " << n;
      seen += expected > 0.05;
    }
    EXPECT_GT(seen, 2) << c.name;
  }
}

TEST_P(BackendLargestWeight, KeepsWhatEarlierBatchesHadMoreOf) {
  TestScene<double> scene = random_scene(40, 40, 0.2, 92);
  const std::vector<float> none(80, 0.0f), half(80, 0.5f);
  const std::vector<float> alone = weights_of(scene.as<float>(), backend(), none),
                           after = weights_of(scene.as<float>(), backend(), half);
  for (size_t n = 0; n < alone.size(); ++n) EXPECT_EQ(after[n], std::max(alone[n], 0.5f));
}

TEST_P(BackendLargestWeight, OfABatchIsTheLargestOfItsViews) {
  TestScene<double> scene = random_scene(60, 60, 0.2, 93);
  const std::vector<float> batch =
      weights_of(scene.as<float>(), backend(), std::vector<float>(120, 0.0f));
  std::vector<float> single(120, 0.0f);
  for (const View& view : std::vector<View>(scene.views)) {
    scene.views = {view};
    single = weights_of(scene.as<float>(), backend(), single);
  }
  EXPECT_EQ(batch, single);
}

// Bug put back: a splat that draws no pixel passed over by the CPU's maximum; seen to fail.
TEST_P(BackendLargestWeight, OfAGaussianWithoutASplatStaysAsItWas) {
  TestScene<double> scene = random_scene(60, 60, 0.2, 95);
  for (int64_t n = 0; n < 10; ++n) scene.fixed.at(kMean, n)[1] = 500;  // in no view
  const TestScene<float> stated = scene.as<float>();
  const std::vector<float> unknown(120, -1.0f), none(120, 0.0f);
  const std::vector<float> found = weights_of(stated, backend(), unknown),
                           from_none = weights_of(stated, backend(), none);
  CpuBackend<float> cpu;
  const std::vector<float> expected = weights_of(stated, cpu, unknown);
  for (size_t n = 0; n < 120; ++n) EXPECT_NEAR(found[n], expected[n], kTolerance) << n;
  for (size_t n = 0; n < 120; ++n) {
    EXPECT_TRUE(n >= 10 || found[n] == -1.0f) << n;
    EXPECT_TRUE(found[n] == -1.0f || found[n] == from_none[n]) << n;
  }
  EXPECT_LT(std::count(found.begin(), found.end(), -1.0f), 60);
}

TEST_P(BackendLargestWeight, NeedsAForwardPassForItAndOneValueAGaussian) {
  const TestScene<float> scene = random_scene(5, 5, 0.2, 94).as<float>();
  const StoredScene<float> in(scene, memory());
  Pipeline<float> pipeline(backend());
  Buffer<float> elements = stored(std::vector<float>(10, 0.0f), memory());
  pipeline.forward(in.forward(false));
  EXPECT_ANY_THROW(pipeline.add_largest_weights(elements.span()));
  pipeline.forward(in.forward(true));
  elements.resize(9);
  EXPECT_ANY_THROW(pipeline.add_largest_weights(elements.span()));
}

}  // namespace
}  // namespace tessera::testing
