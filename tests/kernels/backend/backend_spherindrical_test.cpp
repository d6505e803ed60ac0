// What: colours that follow time, of every backend: images and gradients against the oracle's,
// the fused optimizer against the separate one, levels that catch up against those that take every
// step, and sets without levels against sets whose levels are not active.
// Not: that the oracle is right (brute_force_test.cpp, gradient_test.cpp).
#include "kernels/lazy_schedule.h"
#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/backends.h"
#include "tests/support/optimised.h"

namespace tessera::testing {
namespace {

/// Levels in a scene of both sets; rows of 12 or 48 scalars are read in fours, of 27 one by one.
TestScene<double> levelled_scene(Form form, int levels, uint64_t seed, int coefficients = 16) {
  TestScene<double> scene = random_scene(60, 0, 0.12, seed, form);
  Random random(seed + 1);
  scene.moving = random_gaussians(form, 150, 0.9, 0.12, random, coefficients);
  add_time_levels(scene.moving, levels, seed + 2);
  keep_truth_away(scene, seed + 3);
  return scene;
}

class BackendSpherindrical : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendSpherindrical);

TEST_P(BackendSpherindrical, ImagesAndGradientsAreTheOracles) {
  // Bugs put back in float alone, each seen to fail: weights left out of the gradient; the slope
  // left out of the mean time's; levels left out of the colour.
  struct Case {
    Form form;
    int levels, active, coefficients;
  };
  for (const auto& [form, levels, active, coefficients] : {Case{Form::kPair, 2, 2, 16},
                                                           {Form::kVelocity, 2, 1, 16},
                                                           {Form::kPair, 1, 1, 9},
                                                           {Form::kVelocity, 2, 2, 9},
                                                           {Form::kVelocity, 1, 1, 4},
                                                           {Form::kPair, 2, 2, 1}}) {
    SCOPED_TRACE(std::string(form_name(form)) + ", coefficients " + std::to_string(coefficients));
    TestScene<double> scene = levelled_scene(form, levels, 81, coefficients);
    scene.options.sh_time_degree = active, scene.options.sh_time_period = 0.9;
    keep_truth_away(scene, 85);
    const Backward<float> actual = backward(scene.as<float>(), backend());
    const Backward<double> expected = backward(scene);
    EXPECT_EQ(actual.bad, 0u);
    expect_batch(actual.rendered.colour, actual.rendered.transmittance, expected.rendered,
                 critical_pixels(scene));
    for (int g = 0; g < kGroupCount; ++g)
      expect_group(actual.moving.group[g], expected.moving.group[g], kGradientBounds,
                   group_name(Group(g), form));
  }
}

TEST_P(BackendSpherindrical, ReportsLevelsThatAreNotFinite) {  // C20
  // Bug put back: their bit not set; seen to fail.
  const TestScene<float> scene = levelled_scene(Form::kPair, 1, 83).as<float>();
  const auto result = backward<float>(scene, backend(), [](std::vector<float>& d) {
    for (float& x : d) x = std::numeric_limits<float>::quiet_NaN();
  });
  EXPECT_EQ(result.bad, (1u << kGroupCount) - 1);
}

/// Bit for bit: sets that store levels which are not active are drawn and trained as those without.
TEST_P(BackendSpherindrical, NotActiveIsAsNone) {
  // Bug put back: levels evaluated whatever sh_time_degree says; seen to fail.
  for (const Form form : kDynamicForms) {
    TestScene<float> scene = levelled_scene(form, 2, 87).as<float>();
    scene.options.kernels.deterministic = true, scene.options.sh_time_degree = 0;
    TestScene<float> none = scene;
    none.moving.time_levels = 0, none.moving.group[kShTime].clear();
    const Backward<float> a = backward(scene, backend()), b = backward(none, backend());
    EXPECT_EQ(a.rendered.colour, b.rendered.colour);
    for (int g = 0; g < kShTime; ++g) EXPECT_EQ(a.moving.group[g], b.moving.group[g]);
    for (const float g : a.moving.group[kShTime]) ASSERT_EQ(g, 0.0f);
  }
}

/// A step of the optimizer on the gradient of the whole chain.
TestGaussians<float> stepped(const TestScene<float>& scene, Backend& backend, bool fused) {
  const StoredScene<float> in(scene, backend.memory());
  Optimised<float> state(scene, backend.memory());
  Pipeline<float> pipeline(backend);
  pipeline.forward(
      {{state.value[0].view(), state.value[1].view()}, in.views, in.options, {}, true});
  pipeline.loss(in.target(), true);
  BackwardArgs<float> args;
  for (size_t set = 0; set < 2; ++set) args.sinks[set] = state.sink(set, 101, fused);
  pipeline.backward(args);
  for (size_t set = 0; set < 2 && !fused; ++set) backend.adam(args.sinks[set]);
  return state.value[1].fetch();
}

TEST_P(BackendSpherindrical, FusedEqualsSeparate) {
  // Bug put back: levels left out of the separate one; seen to fail.
  for (const int coefficients : {16, 9}) {
    TestScene<float> scene = levelled_scene(Form::kVelocity, 2, 89, coefficients).as<float>();
    scene.options.kernels.deterministic = true;
    const TestGaussians<float> fused = stepped(scene, backend(), true);
    const TestGaussians<float> separate = stepped(scene, backend(), false);
    for (int g = 0; g < kGroupCount; ++g)
      EXPECT_EQ(fused.group[g], separate.group[g]) << group_name(Group(g), Form::kVelocity);
    EXPECT_NE(fused.group[kShTime], scene.moving.group[kShTime]);
  }
}

/// 30 steps of colours with one of three views at a time: most Gaussians are idle in most steps.
class Idle {
 public:
  Idle(const TestScene<float>& scene, Backend& backend, IdleUpdate idle)
      : in_(scene, backend.memory()),
        state_(scene, backend.memory()),
        table_(stored(lazy_adam_table(kSteps), backend.memory())),
        last_step_(stored(std::vector<int32_t>(size_t(scene.moving.count), 0), backend.memory())),
        backend_(backend),
        idle_(idle) {
    for (StoredGaussians<float>* m : {&state_.moment1[1], &state_.moment2[1]})
      for (const Group g : {kSh, kShTime}) backend.fill_zero(m->spans().group[g]);
  }

  TestGaussians<float> run() {
    for (int64_t step = 1; step <= kSteps; ++step) take(step);
    if (idle_ == IdleUpdate::kLazy) backend_.catch_up(lazy(kSteps));
    return state_.value[1].fetch();
  }

 private:
  static constexpr int64_t kSteps = 30;

  LazySh<float> lazy(int64_t done) {
    if (idle_ != IdleUpdate::kLazy) return {};
    const GaussianSpans<float> x = state_.value[1].spans(), m = state_.moment1[1].spans(),
                               v = state_.moment2[1].spans();
    return {
        last_step_.span(), table_.span(), x.group[kSh],     m.group[kSh],     v.group[kSh],    done,
        2.5e-3f,           1.25e-4f,      x.group[kShTime], m.group[kShTime], v.group[kShTime]};
  }

  void take(int64_t step) {
    Pipeline<float> pipeline(backend_);
    const size_t view = size_t(step % 3);
    pipeline.forward({{in_.sets[0].view(), std::as_const(state_.value[1]).view()},
                      {in_.views[view]},
                      in_.options,
                      {{}, lazy(step - 1)},
                      true});
    const Target all = in_.target();
    pipeline.loss({{all.truth[view]}, all.weights, {}}, true);
    BackwardArgs<float> args;
    args.sinks[0] = state_.sink(0, step, false);
    args.sinks[1] = state_.sink(1, step, true, idle_);
    for (AdamScalars<float>& group : args.sinks[1].adam.group) group = adam_scalars<float>(0, step);
    args.sinks[1].adam.group[kSh] = adam_scalars<float>(2.5e-3, step);
    args.sinks[1].adam.sh_rest = adam_scalars<float>(1.25e-4, step);
    args.sinks[1].lazy = lazy(step - 1);
    pipeline.backward(args);
  }

  StoredScene<float> in_;
  Optimised<float> state_;
  Buffer<double> table_;
  Buffer<int32_t> last_step_;
  Backend& backend_;
  IdleUpdate idle_;
};

TEST_P(BackendSpherindrical, LevelsThatCatchUpEqualThoseThatTakeEveryStep) {
  // Bugs put back, each seen to fail: levels do not catch up; they do so, or take their steps, at
  // the rate of the first coefficient.
  TestScene<double> start = levelled_scene(Form::kVelocity, 2, 91);
  for (double& x : start.moving.group[kMean]) x *= 2.5;  // outside some of the views
  for (double& c : start.moving.group[kShTime]) c *= 0.3;
  for (double& s : start.moving.group[kLogScaleTime]) s -= 1.2;
  const TestScene<float> scene = start.as<float>();
  const TestGaussians<float> dense = Idle(scene, backend(), IdleUpdate::kDense).run();
  const TestGaussians<float> lazy = Idle(scene, backend(), IdleUpdate::kLazy).run();
  const auto& before = scene.moving.group[kShTime];
  expect_group(change(lazy.group[kShTime], before), change(dense.group[kShTime], before),
               {1e-3, 1e-2, 0.01, 1e-3}, "sh_time");
  EXPECT_NE(dense.group[kShTime], before);
}

}  // namespace
}  // namespace tessera::testing
