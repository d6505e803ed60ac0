// No kernel switch changes the result: the images of each equal those of the default, its gradients
// equal the oracle's, and looser bounds list supersets of the instances.
#include <map>

#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/backends.h"
#include "tests/support/stage_run.h"

namespace tessera::testing {
namespace {

struct Variant {
  const char* name;
  void (*set)(KernelSwitches&);
  bool lists_more;  // than the default: instances where nothing is drawn
};

constexpr Variant kVariants[] = {
    {"square bounds", [](KernelSwitches& k) { k.bounds.rectangular = false; }, true},
    {"bounds of an opaque splat", [](KernelSwitches& k) { k.bounds.opacity_aware = false; }, true},
    {"bounds of 3DGS",
     [](KernelSwitches& k) {
       k.bounds = {false, false};
     },
     true},
    {"a thread a splat", [](KernelSwitches& k) { k.balanced_instances = false; }, false},
    {"one sort", [](KernelSwitches& k) { k.separate_sort = false; }, false},
    {"one sort, deterministic",
     [](KernelSwitches& k) {
       k.separate_sort = false;
       k.deterministic = true;
     },
     false},
    {"no warp culling", [](KernelSwitches& k) { k.warp_culling = false; }, false},
    {"backward by pixels", [](KernelSwitches& k) { k.backward = BackwardForm::kPixel; }, false},
    {"backward by pixels, deterministic",
     [](KernelSwitches& k) {
       k.backward = BackwardForm::kPixel;
       k.deterministic = true;
     },
     false},
    {"deterministic", [](KernelSwitches& k) { k.deterministic = true; }, false},
    {"all off",
     [](KernelSwitches& k) {
       k.bounds = {false, false};
       k.balanced_instances = k.separate_sort = k.warp_culling = false;
       k.backward = BackwardForm::kPixel;
     },
     true},
};

TestScene<double> with(TestScene<double> scene, const Variant& variant) {
  variant.set(scene.options.kernels);
  return scene;
}

std::vector<TestScene<double>> switch_scenes() {
  std::vector<TestScene<double>> scenes{random_scene(200, 200, 0.15, 61),
                                        random_scene(60, 60, 0.6, 62)};
  TestScene<double> opaque = random_scene(200, 150, 0.4, 63);
  for (double& logit : opaque.fixed.group[kOpacityLogit]) logit = 4;
  TestScene<double> needles = random_scene(100, 100, 0.1, 64);
  Random random(65);
  for (TestGaussians<double>* set : {&needles.fixed, &needles.moving})
    for (double& x : set->group[kLogScale]) x = random.below(2) ? std::log(0.8) : std::log(0.004);
  TestScene<double> deep = random_scene(900, 900, 0.25, 66);  // hundreds of splats a tile
  for (TestGaussians<double>* set : {&deep.fixed, &deep.moving})
    for (double& logit : set->group[kOpacityLogit]) logit -= 3;
  for (const TestScene<double>& scene : {opaque, needles, deep}) scenes.push_back(scene);
  for (TestScene<double>& scene : scenes) keep_truth_away(scene, 67);
  return scenes;
}

class BackendSwitches : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendSwitches);

TEST_P(BackendSwitches, ImagesAndGradientsDoNotChange) {
  // Bugs put back, each seen to fail: one form's d_opacity 0.2 % off; the last tile of a row left
  // out.
  for (const TestScene<double>& scene : switch_scenes()) {
    const Backward<double> expected = backward(scene);
    const auto critical = critical_pixels(scene);
    const Rendered<float> usual = render(scene.as<float>(), backend());
    for (const Variant& variant : kVariants) {
      SCOPED_TRACE(variant.name);
      const Backward<float> actual = backward(with(scene, variant).as<float>(), backend());
      EXPECT_EQ(actual.bad, 0u);
      expect_batch(actual.rendered.colour, actual.rendered.transmittance, expected.rendered,
                   critical);
      size_t apart = 0;  // the same products, but perhaps contracted otherwise
      for (size_t i = 0; i < usual.colour.size(); ++i)
        apart += !(std::abs(actual.rendered.colour[i] - usual.colour[i]) <= 2e-6);
      EXPECT_LE(apart, usual.colour.size() / 1000);
      for (int g = 0; g < kGroupCount; ++g) {
        expect_group(actual.fixed.group[g], expected.fixed.group[g], kGradientBounds,
                     group_name(Group(g), SetForm::kStatic));
        expect_group(actual.moving.group[g], expected.moving.group[g], kGradientBounds,
                     group_name(Group(g), SetForm::kPair));
      }
      for (size_t set = 0; set < 2; ++set)
        expect_group(actual.statistic[set], expected.statistic[set], kGradientBounds, "statistic");
    }
  }
}

/// (tile, splat's key) of every instance → the splat.
std::map<std::pair<int64_t, int64_t>, Splat<float>> listed(const StageRun<float>& run) {
  std::map<std::pair<int64_t, int64_t>, Splat<float>> all;
  const std::vector<int64_t> keys = run.keys();
  for (int64_t t = 0; t < run.batch.tiles; ++t)
    for (int64_t i = run.tile_begin[size_t(t)]; i < run.tile_begin[size_t(t) + 1]; ++i) {
      const size_t s = size_t(run.instance_splat[size_t(i)]);
      all.emplace(std::pair(t, keys[s]), run.splat[s]);
    }
  return all;
}

TEST_P(BackendSwitches, LooserBoundsListSupersets) {
  // Bug put back: bounds of a splat of opacity 0.5 for opaque ones; seen to fail.
  const TestScene<double> scene = switch_scenes()[0];
  const StageRun<float> run = run_stages(scene.as<float>(), backend());
  const auto usual = listed(run);
  for (const Variant& variant : kVariants) {
    SCOPED_TRACE(variant.name);
    const auto now = listed(run_stages(with(scene, variant).as<float>(), backend()));
    for (const auto& [pair, splat] : usual) EXPECT_EQ(now.count(pair), 1u);
    if (variant.lists_more)
      EXPECT_GT(now.size(), usual.size() + usual.size() / 50);
    else
      EXPECT_EQ(now.size(), usual.size());
  }
}

TEST_P(BackendSwitches, EveryDeterministicFormIsEqualToTheBitTwice) {  // C18
  // Bug put back: d_opacity 1e-6 off from run to run; seen to fail.
  const TestScene<double> scene = random_scene(500, 500, 0.2, 68);
  for (const Variant& variant : kVariants) {
    SCOPED_TRACE(variant.name);
    TestScene<float> fixed_order = with(scene, variant).as<float>();
    fixed_order.options.kernels.deterministic = true;
    const Backward<float> a = backward(fixed_order, backend());
    const Backward<float> b = backward(fixed_order, backend());
    EXPECT_EQ(a.rendered.colour, b.rendered.colour);
    for (int g = 0; g < kGroupCount; ++g) {
      EXPECT_EQ(a.fixed.group[g], b.fixed.group[g]) << group_name(Group(g), SetForm::kStatic);
      EXPECT_EQ(a.moving.group[g], b.moving.group[g]) << group_name(Group(g), SetForm::kPair);
    }
  }
}

}  // namespace
}  // namespace tessera::testing
