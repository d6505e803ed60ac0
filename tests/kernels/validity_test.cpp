// Gaussians of zero scale on the CPU against the brute-force renderer.
#include "tests/support/brute_force.h"
#include "tests/support/compare.h"
#include "tests/support/render.h"
#include "tests/support/victim.h"

namespace tessera::testing {
namespace {

void expect_culled_and_counted(const TestScene<float>& spoilt, SetForm form, const char* what) {
  testing::expect_culled_and_counted(spoilt, form, what,
                                     [](const TestScene<float>& scene) { return backward(scene); });
}

TEST(Validity, NonFiniteFieldIsCulledAndCounted) {
  // Bugs put back, seen to fail: the logit, or the log scale of time, not looked at.
  const TestScene<float> scene = random_scene(10, 10, 0.3, 1).as<float>();
  for (const SetForm form : {SetForm::kStatic, SetForm::kPair})
    for (int g = 0; g < group_count(form); ++g)
      for (int i = 0; i < group_width(Group(g), 16, form); i += g == kSh ? 11 : 1)
        for (const float value : {kNan, kInf, -kInf}) {
          TestScene<float> spoilt = scene;
          (form == SetForm::kStatic ? spoilt.fixed : spoilt.moving).at(Group(g), kVictim)[i] =
              value;
          expect_culled_and_counted(spoilt, form, group_name(Group(g), form));
        }
}

TEST(Validity, ZeroQuaternionIsCulledAndCounted) {
  // Bug put back: no test of the norm; seen to fail.
  const TestScene<float> scene = random_scene(10, 10, 0.3, 2).as<float>();
  for (const Group g : {kRotation, kRotationRight})
    for (const float length : {0.0f, 5e-5f}) {
      TestScene<float> spoilt = scene;
      std::fill_n(spoilt.moving.at(g, kVictim), 4, length / 2);
      expect_culled_and_counted(spoilt, SetForm::kPair, group_name(g, SetForm::kPair));
      if (g != kRotation) continue;
      spoilt = scene;
      std::fill_n(spoilt.fixed.at(g, kVictim), 4, length / 2);
      expect_culled_and_counted(spoilt, SetForm::kStatic, group_name(g, SetForm::kStatic));
    }
}

TEST(Validity, ZeroScaleIsADotOfTheDilation) {
  TestScene<double> scene = random_scene(10, 10, 0.3, 3);
  std::fill_n(scene.fixed.at(kLogScale, kVictim), 3, -60.0);  // e^{2·−60} vanishes in float
  const TestScene<float> rough = scene.as<float>();
  const Backward<float> result = backward(rough);
  EXPECT_EQ(result.rendered.report.invalid_gaussians, 0);
  EXPECT_EQ(result.bad, 0u);
  const BruteImage expected = render_brute(scene, scene.views[0], 1e-4);
  expect_image(result.rendered.colour.data(), expected.colour, expected.critical,
               {1e-5, 1.2 / 255, 0.02, 1e-6}, "colour");
}

TEST(Validity, NeedleOfAMillionToOneIsFinite) {
  TestScene<float> scene = random_scene(10, 10, 0.3, 4).as<float>();
  for (TestGaussians<float>* set : {&scene.fixed, &scene.moving}) {
    set->at(kLogScale, kVictim)[0] = std::log(100.0f);
    set->at(kLogScale, kVictim)[1] = set->at(kLogScale, kVictim)[2] = std::log(1e-4f);
  }
  const Backward<float> result = backward(scene);
  EXPECT_EQ(result.bad, 0u);
  for (const float c : result.rendered.colour) ASSERT_TRUE(std::isfinite(c));
  for (const float T : result.rendered.transmittance) ASSERT_TRUE(T >= 0 && T <= 1);
}

TEST(Validity, HugeFiniteValuesAreFinite) {
  for (const float value : {1e10f, 1e19f, 1e30f, 3e38f})
    for (const Group g : {kMean, kLogScale, kRotation, kOpacityLogit, kMeanTime, kLogScaleTime})
      for (const float sign : {1.0f, -1.0f}) {
        TestScene<float> scene = random_scene(10, 10, 0.3, 5).as<float>();
        scene.moving.at(g, kVictim)[0] = sign * value;
        if (g < kStaticGroups) scene.fixed.at(g, kVictim)[0] = sign * value;
        const Backward<float> result = backward(scene);
        EXPECT_EQ(result.bad, 0u) << group_name(g, SetForm::kPair) << " " << sign * value;
        for (const float c : result.rendered.colour)
          ASSERT_TRUE(std::isfinite(c)) << group_name(g, SetForm::kPair) << " " << sign * value;
      }
}

/// One static Gaussian's gradient with one field of its splat's gradient spoilt.
unsigned groups_reported(const TestScene<float>& scene,
                         const std::function<void(SplatMoments<float>&)>& spoil) {
  CpuBackend<float> backend;
  const ViewBatch<float> batch = make_view_batch<float>(scene.views);
  ProjectBackwardArgs<float> args;
  args.forward = {&batch, {scene.fixed.view(), scene.moving.view()}, scene.options};
  Splats<float> splats;
  backend.project(args.forward, splats);
  std::vector<SplatMoments<float>> d_splats(size_t(splats.count));
  TestGaussians<float> fixed(SetForm::kStatic, scene.fixed.count);
  TestGaussians<float> moving(SetForm::kPair, scene.moving.count);
  args.splats = &splats;
  args.d_splats = {d_splats.data(), splats.count};
  args.sinks[0].gradient = fixed.spans();
  args.sinks[1].gradient = moving.spans();
  backend.project_backward(args);
  EXPECT_EQ(backend.outcome().bad_groups, 0u);
  spoil(d_splats[d_splats.size() / 2]);
  backend.project_backward(args);
  return backend.outcome().bad_groups;
}

TEST(Validity, NonFiniteGradientNamesItsGroups) {  // C20
  // Bug put back: non_finite without the last group; seen to fail.
  const TestScene<float> still = random_scene(5, 0, 0.3, 6).as<float>();
  const TestScene<float> moving = random_scene(0, 5, 0.3, 6).as<float>();
  const auto bits = [](std::initializer_list<Group> groups) {
    unsigned all = 0;
    for (const Group g : groups) all |= 1u << g;
    return all;
  };
  for (const float bad : {kNan, kInf}) {
    const auto opacity = [bad](SplatMoments<float>& d) { d.f = bad; };
    const auto position = [bad](SplatMoments<float>& d) { d.f_d[0] = bad; };
    const auto conic = [bad](SplatMoments<float>& d) { d.f_dd.xx = bad; };
    const auto colour = [bad](SplatMoments<float>& d) { d.colour = Vec3<float>(bad); };
    EXPECT_EQ(groups_reported(still, opacity), bits({kOpacityLogit}));
    EXPECT_EQ(groups_reported(still, position), bits({kMean}));
    EXPECT_EQ(groups_reported(still, conic), bits({kMean, kLogScale, kRotation}));
    EXPECT_EQ(groups_reported(still, colour), bits({kMean, kSh}));
    EXPECT_EQ(groups_reported(moving, opacity), bits({kOpacityLogit, kMeanTime, kLogScale,
                                                      kLogScaleTime, kRotation, kRotationRight}));
  }
}

TEST(Validity, NonFiniteImageGradientIsReported) {  // C20
  const TestScene<float> scene = random_scene(5, 5, 0.3, 7).as<float>();
  const auto result = backward<float>(scene, [](std::vector<float>& d) {
    for (float& x : d) x = kNan;
  });
  EXPECT_EQ(result.bad, (1u << kShTime) - 1) << "all that there are";
}

}  // namespace
}  // namespace tessera::testing
