// Canonical sets on every backend against the oracle: the Gaussians carried by motion nodes in each
// view, the images, and the gradients of Gaussians and nodes. The oracle is compared with central
// differences in motion_nodes_test.cpp.
#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/backends.h"
#include "tests/support/carried_scene.h"
#include "tests/support/optimised.h"

namespace tessera::testing {
namespace {

/// Rounding of a blend of eight poses of order 1.
constexpr double kTolerance = 2e-5;

class BackendCarry : public EveryBackend {
 protected:
  void expect_gradients(TestScene<double> scene) {
    keep_truth_away(scene, 7);
    const Backward<double> expected = backward(scene);
    const Backward<float> actual = backward(scene.as<float>(), backend());
    EXPECT_EQ(actual.bad, 0u);
    for (const Group g : {kMean, kLogScale, kRotation, kOpacityLogit, kSh, kNodeLogit})
      expect_group(actual.fixed.group[g], expected.fixed.group[g], kGradientBounds,
                   group_name(g, SetForm::kCanonical));
    for (int g = 0; g < kDynamicGroups; ++g)
      expect_group(actual.moving.group[g], expected.moving.group[g], kGradientBounds,
                   group_name(Group(g), SetForm::kPair));
    expect_group(actual.statistic[0], expected.statistic[0], kGradientBounds, "statistic");
    Backward<float> a = actual;
    Backward<double> e = expected;
    const char* const names[] = {"position", "log_radius", "translation", "rotation"};
    for (size_t i = 1; i < 4; ++i)
      expect_group(*a.d_nodes.arrays()[i], *e.d_nodes.arrays()[i], kGradientBounds, names[i]);
  }
};
TESSERA_ON_EVERY_BACKEND(BackendCarry);

template <class Real>
std::vector<CarriedGaussian<Real>> carried(const TestScene<Real>& scene, BackendOf<Real>& backend) {
  Memory& memory = backend.memory();
  const StoredScene<Real> in(scene, memory);
  const ViewBatch<Real> batch = make_view_batch<Real>(scene.views);
  Carried<Real> out(memory);
  backend.carry({&batch, in.sets[0].view(), in.nodes.view()}, out);
  return fetched(out.gaussians, memory);
}

TEST_P(BackendCarry, MeansAndRotationsEqualTheOracles) {
  const TestScene<double> scene = carried_scene(1, 500, 70);
  CpuBackend<double> oracle;
  const auto expected = carried(scene, oracle);
  const auto actual = carried(scene.as<float>(), backend());
  ASSERT_EQ(actual.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(actual[i].mean[c], expected[i].mean[c], kTolerance) << i;
    for (int c = 0; c < 4; ++c)
      ASSERT_NEAR(actual[i].rotation[c], expected[i].rotation[c], kTolerance) << i;
  }
}

/// The scene as one of its views sees it, with a static set in the place of the canonical one.
TestScene<double> posed(const TestScene<double>& scene, size_t view) {
  CpuBackend<double> oracle;
  const auto gaussians = carried(scene, oracle);
  TestScene<double> still = scene;
  still.nodes = {};
  still.fixed.form = SetForm::kStatic;
  still.fixed.group[kNode].clear();
  still.fixed.group[kNodeLogit].clear();
  for (int64_t n = 0; n < scene.fixed.count; ++n) {
    const CarriedGaussian<double>& g = gaussians[view * size_t(scene.fixed.count) + size_t(n)];
    for (int c = 0; c < 3; ++c) still.fixed.at(kMean, n)[c] = g.mean[c];
    for (int c = 0; c < 4; ++c) still.fixed.at(kRotation, n)[c] = g.rotation[c];
  }
  still.views = {scene.views[view]};
  return still;
}

TEST_P(BackendCarry, ImagesAreThoseOfTheSetAsEachViewSeesIt) {
  const TestScene<double> scene = carried_scene(2, 150, 20, 0.15, 40);
  Rendered<double> expected;
  std::vector<std::vector<bool>> critical;
  for (size_t b = 0; b < scene.views.size(); ++b) {
    const TestScene<double> still = posed(scene, b);
    const Rendered<double> view = render(still);
    expected.colour.insert(expected.colour.end(), view.colour.begin(), view.colour.end());
    expected.transmittance.insert(expected.transmittance.end(), view.transmittance.begin(),
                                  view.transmittance.end());
    critical.push_back(critical_pixels(still)[0]);
  }
  const Rendered<float> actual = render(scene.as<float>(), backend());
  expect_batch(actual.colour, actual.transmittance, expected, critical);
}

TEST_P(BackendCarry, GradientsEqualTheOracles) {
  expect_gradients(carried_scene(3, 60, 9, 0.2));
}

/// Nodes of many Gaussians, of few and of none; more Gaussians than a block has threads.
TEST_P(BackendCarry, GradientsOfOneNodeAndOfMany) {
  for (const int64_t nodes : {int64_t{1}, int64_t{40}, int64_t{300}}) {
    SCOPED_TRACE(nodes);
    expect_gradients(carried_scene(4, 700, nodes, 0.1));
  }
}

TEST_P(BackendCarry, WithoutNodesOrGaussiansThereIsNothingToCarry) {
  TestScene<double> scene = carried_scene(5, 20, 5);
  scene.nodes = {};
  std::fill(scene.fixed.group[kNode].begin(), scene.fixed.group[kNode].end(), -1.0);
  expect_gradients(scene);
  scene = carried_scene(6, 20, 5);
  Random random(8);
  scene.fixed = canonical(TestGaussians<double>(SetForm::kStatic), scene.nodes, random,
                          [](int64_t) { return 1; });
  expect_gradients(scene);
}

TEST_P(BackendCarry, EqualInputsGiveEqualBits) {
  TestScene<float> scene = carried_scene(7, 400, 30, 0.1).as<float>();
  scene.options.kernels.deterministic = true;
  Backward<float> one = backward(scene, backend()), other = backward(scene, backend());
  for (size_t i = 1; i < 4; ++i) EXPECT_EQ(*one.d_nodes.arrays()[i], *other.d_nodes.arrays()[i]);
  EXPECT_EQ(one.fixed.group[kMean], other.fixed.group[kMean]);
  EXPECT_EQ(one.fixed.group[kNodeLogit], other.fixed.group[kNodeLogit]);
}

}  // namespace
}  // namespace tessera::testing
