// Every run gives the same bits, with any number of threads and in reused memory, and the fused
// optimizer equals the separate one. Equality between different machines is not tested. Source:
// failure mode C18.
#include "kernels/base/parallel.h"
#include "tests/support/render.h"

namespace tessera::testing {
namespace {

template <class Real>
void expect_same(const Backward<Real>& a, const Backward<Real>& b) {
  EXPECT_EQ(a.rendered.colour, b.rendered.colour);
  EXPECT_EQ(a.rendered.transmittance, b.rendered.transmittance);
  EXPECT_EQ(a.rendered.used, b.rendered.used);
  for (size_t v = 0; v < a.losses.size(); ++v) EXPECT_EQ(a.losses[v].total, b.losses[v].total);
  for (int g = 0; g < kGroupCount; ++g) {
    EXPECT_EQ(a.fixed.group[g], b.fixed.group[g]);
    EXPECT_EQ(a.moving.group[g], b.moving.group[g]);
  }
  for (int set = 0; set < 2; ++set) EXPECT_EQ(a.statistic[set], b.statistic[set]);
}

TEST(Determinism, ThreadsDoNotChangeABit) {
  // Bug put back: instances summed in another order with more than one thread; seen to fail.
  // more splats than one task of any stage takes
  const TestScene<float> scene = random_scene(5000, 5000, 0.05, 1).as<float>();
  set_thread_count(1);
  const Backward<float> one = backward(scene);
  for (const int threads : {2, 3}) {
    set_thread_count(threads);
    expect_same(backward(scene), one);
  }
  set_thread_count(0);
  EXPECT_GT(one.rendered.report.splats, 16384);
}

TEST(Determinism, RepeatedCallsAreEqual) {
  const TestScene<float> scene = random_scene(300, 300, 0.2, 2).as<float>();
  expect_same(backward(scene), backward(scene));
}

TEST(Determinism, ReusedBuffersLeaveNoTrace) {
  // Bug put back: `used` not reset in a tile without instances; seen to fail.
  const TestScene<float> large = random_scene(300, 300, 0.3, 3).as<float>();
  const TestScene<float> small = random_scene(2, 1, 0.05, 4).as<float>();
  CpuBackend<float> backend;
  Pipeline<float> pipeline(backend);
  const auto forward = [&](const TestScene<float>& scene) {
    const Images<float>& images =
        pipeline.forward(scene.fixed.view(), scene.moving.view(), scene.views, scene.options, true);
    return copy_of(images, pipeline.report());
  };
  forward(large);
  const Rendered<float> reused = forward(small), fresh = render(small);
  EXPECT_EQ(reused.colour, fresh.colour);
  EXPECT_EQ(reused.transmittance, fresh.transmittance);
  EXPECT_EQ(reused.used, fresh.used);
  EXPECT_EQ(forward(large).colour, render(large).colour);
}

/// Three optimizer steps, fused or as gradient and Adam apart.
template <class Real>
TestGaussians<Real> trained(TestScene<Real> scene, bool fused) {
  TestGaussians<Real>* sets[2] = {&scene.fixed, &scene.moving};
  TestGaussians<Real> moment1[2] = {
      TestGaussians<Real>(SetForm::kStatic, scene.fixed.count),
      TestGaussians<Real>(SetForm::kPair, scene.moving.count, 16, scene.moving.time_levels)};
  TestGaussians<Real> moment2[2] = {moment1[0], moment1[1]};
  TestGaussians<Real> gradient[2] = {moment1[0], moment1[1]};
  CpuBackend<Real> backend;
  Pipeline<Real> pipeline(backend);
  for (int step = 1; step <= 3; ++step) {
    BackwardArgs<Real> args;
    for (int set = 0; set < 2; ++set) {
      SinkArgs<Real>& sink = args.sinks[set];
      sink.fused = fused;
      sink.gradient = gradient[set].spans();
      sink.value = sets[set]->spans();
      sink.moment1 = moment1[set].spans();
      sink.moment2 = moment2[set].spans();
      for (int g = 0; g < kGroupCount; ++g)
        sink.adam.group[g] = adam_scalars<Real>(1e-3 * (g + 1), step);
      sink.adam.sh_rest = adam_scalars<Real>(1e-4, step);
    }
    pipeline.forward(scene.fixed.view(), scene.moving.view(), scene.views, scene.options, true);
    pipeline.loss(target_of(scene), true);
    pipeline.backward(args);
    EXPECT_EQ(pipeline.outcome().bad_groups, 0u);
    for (int set = 0; set < 2 && !fused; ++set) backend.adam(args.sinks[set]);
  }
  return scene.moving;
}

template <class Real>
void expect_fused_equals_separate() {
  TestScene<double> start = random_scene(20, 20, 0.2, 5);
  add_time_levels(start.moving, 2, 6);
  const TestScene<Real> scene = start.template as<Real>();
  const TestGaussians<Real> a = trained(scene, true), b = trained(scene, false);
  for (int g = 0; g < kDynamicGroups; ++g) {
    EXPECT_EQ(a.group[g], b.group[g]) << group_name(Group(g), SetForm::kPair);
    EXPECT_NE(a.group[g], scene.moving.group[g]) << group_name(Group(g), SetForm::kPair);
  }
}

TEST(Determinism, FusedOptimizerEqualsTheSeparateOne) {
  expect_fused_equals_separate<float>();
  expect_fused_equals_separate<double>();
}

}  // namespace
}  // namespace tessera::testing
