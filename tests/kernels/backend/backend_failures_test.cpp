// Invalid, extreme and degenerate Gaussians on every backend: they are rendered correctly or culled
// and counted, and all other pixels are unchanged. The groups of a non-finite gradient are named.
// Source: failure modes C3, C4, C5, C9, C10, C14, C15, C20.
#include <limits>

#include "tests/support/backends.h"
#include "tests/support/front_scene.h"
#include "tests/support/stage_run.h"

namespace tessera::testing {
namespace {

constexpr int64_t kVictim = 4;  // of 10 in each set
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

TestGaussians<float> without_victim(const TestGaussians<float>& set) {
  std::vector<int64_t> rest;
  for (int64_t n = 0; n < set.count; ++n)
    if (n != kVictim) rest.push_back(n);
  return set.select(rest);
}

constexpr int kMiddlePixel = kFrontMiddle * kFrontSize + kFrontMiddle;

class BackendFailures : public EveryBackend {
 protected:
  /// The victim of one set is spoilt: it is counted once, and images and gradients of all others
  /// are those of the scene without it.
  void expect_culled_and_counted(const TestScene<float>& spoilt, SetForm form, const char* what) {
    TestScene<float> rest = spoilt;
    TestGaussians<float>& set = form == SetForm::kStatic ? rest.fixed : rest.moving;
    set = without_victim(set);
    const Backward<float> a = backward(spoilt, backend()), b = backward(rest, backend());
    EXPECT_EQ(a.rendered.report.invalid_gaussians, 1) << what;
    EXPECT_EQ(a.rendered.colour, b.rendered.colour) << what;
    EXPECT_EQ(a.rendered.transmittance, b.rendered.transmittance) << what;
    EXPECT_EQ(a.bad, 0u) << what;
    const TestGaussians<float>&ga = form == SetForm::kStatic ? a.fixed : a.moving,
          &gb = form == SetForm::kStatic ? b.fixed : b.moving;
    for (int g = 0; g < group_count(form); ++g) {
      EXPECT_EQ(without_victim(ga).group[g], gb.group[g]) << what;
      for (int i = 0; i < group_width(Group(g), 16, form); ++i)
        EXPECT_EQ(ga.at(Group(g), kVictim)[i], 0.0f) << what;
    }
  }

  TestScene<float> scene_to_spoil(uint64_t seed) {
    TestScene<float> scene = random_scene(10, 10, 0.3, seed).as<float>();
    scene.options.kernels.deterministic = true;  // unchanged pixels have equal bits
    return scene;
  }

  void expect_finite(const TestScene<float>& scene, const char* what) {
    const Backward<float> result = backward(scene, backend());
    EXPECT_EQ(result.bad, 0u) << what;
    for (const float c : result.rendered.colour) ASSERT_TRUE(std::isfinite(c)) << what;
    for (const float T : result.rendered.transmittance) ASSERT_TRUE(T >= 0 && T <= 1) << what;
  }
};
TESSERA_ON_EVERY_BACKEND(BackendFailures);

TEST_P(BackendFailures, CoincidentDuplicatesMultiplyTransmittance) {  // C3
  // Bug put back: T reduced by 0.9999·α; seen to fail.
  TestScene<float> scene = front_scene();
  for (int n = 1; n <= 40; ++n) {
    add_round(scene, {0, 0, 5}, 0.3, 0.2, {0.6, 0.6, 0.6});
    const Rendered<float> once = render(scene, backend()), again = render(scene, backend());
    const double left = std::pow(0.8, n);
    EXPECT_NEAR(once.transmittance[kMiddlePixel], left, 2e-6);
    EXPECT_NEAR(front_pixel(once, 0, kFrontMiddle, kFrontMiddle), 0.6 * (1 - left), 2e-6);
    EXPECT_EQ(once.colour, again.colour);
    EXPECT_EQ(once.used, again.used);
  }
}

TEST_P(BackendFailures, OpacityBelowTheCutoffContributesNothing) {  // C4
  // Bugs put back, seen to fail: gradients of culled Gaussians not written; empty tiles not
  // stored.
  for (const double opacity : {0.0, 1e-90, 1e-9, 1.0 / 256}) {
    TestScene<float> scene = front_scene();
    add_round(scene, {0, 0, 5}, 0.3, opacity, {1, 1, 1});
    if (opacity == 0) *scene.fixed.at(kOpacityLogit, 0) = -200;  // its sigmoid is 0 in float
    const Backward<float> result = backward(scene, backend());
    EXPECT_EQ(result.rendered.report.splats, 0);
    EXPECT_EQ(result.rendered.report.invalid_gaussians, 0);
    EXPECT_EQ(result.bad, 0u);
    for (const float c : result.rendered.colour) ASSERT_EQ(c, 0.0f);
    for (const float T : result.rendered.transmittance) ASSERT_EQ(T, 1.0f);
    EXPECT_EQ(*result.fixed.at(kOpacityLogit, 0), 0.0f);
  }
}

TEST_P(BackendFailures, NonFiniteFieldIsCulledAndCounted) {  // C5
  // Bugs put back, seen to fail: the logit, or the log scale of time, not tested; not
  // counted.
  const TestScene<float> scene = scene_to_spoil(1);
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

TEST_P(BackendFailures, ZeroQuaternionIsCulledAndCounted) {  // C5
  // Bug put back: no test of the norm; seen to fail.
  const TestScene<float> scene = scene_to_spoil(2);
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

TEST_P(BackendFailures, ZeroScaleAndNeedlesAreFinite) {  // C5
  // Bug put back: no dilation and no test of the determinant; seen to fail.
  TestScene<float> scene = scene_to_spoil(3);
  std::fill_n(scene.fixed.at(kLogScale, kVictim), 3, -60.0f);  // e^{2·−60} vanishes in float
  std::fill_n(scene.moving.at(kLogScale, kVictim), 3, -60.0f);
  expect_finite(scene, "zero scale");
  for (TestGaussians<float>* set : {&scene.fixed, &scene.moving}) {
    set->at(kLogScale, kVictim)[0] = std::log(100.0f);
    set->at(kLogScale, kVictim)[1] = set->at(kLogScale, kVictim)[2] = std::log(1e-4f);
  }
  expect_finite(scene, "needle of a million to one");
}

TEST_P(BackendFailures, HugeFiniteValuesAreFinite) {  // C5
  const TestScene<float> scene = scene_to_spoil(5);
  for (const float value : {1e10f, -1e10f, 1e19f, -1e19f, 1e30f, -1e30f, 3e38f, -3e38f})
    for (const Group g : {kMean, kLogScale, kRotation, kOpacityLogit, kMeanTime, kLogScaleTime}) {
      TestScene<float> spoilt = scene;
      spoilt.moving.at(g, kVictim)[0] = value;
      if (g < kStaticGroups) spoilt.fixed.at(g, kVictim)[0] = value;
      expect_finite(spoilt, group_name(g, SetForm::kPair));
    }
}

TEST_P(BackendFailures, NearAndFarPlaneAreInclusive) {  // C9, C10
  // Bugs put back, seen to fail: no far plane; near plane exclusive or 2e-7 further.
  const auto drawn = [&](float z) {
    TestScene<float> scene = front_scene();
    scene.options.near_plane = 0.25;
    scene.options.far_plane = 1024;
    const Rendered<float> empty = render(scene, backend());
    add_round(scene, {0, 0, z}, 0.01 * std::abs(z), 0.8, {1, 1, 1});
    const Rendered<float> r = render(scene, backend());
    if (r.report.splats == 0) {
      EXPECT_EQ(r.colour, empty.colour);
    }
    return r.report.splats == 1 &&
           std::abs(front_pixel(r, 0, kFrontMiddle, kFrontMiddle) - 0.8f) < 1e-5f;
  };
  EXPECT_TRUE(drawn(0.25f));
  EXPECT_FALSE(drawn(std::nextafter(0.25f, 0.0f)));
  EXPECT_TRUE(drawn(1024.0f));
  EXPECT_FALSE(drawn(std::nextafter(1024.0f, 2000.0f)));
  EXPECT_FALSE(drawn(-1.0f));
  EXPECT_FALSE(drawn(1e6f));
}

TEST_P(BackendFailures, GaussianBesideTheCameraDoesNotFlash) {  // C9
  // Bug put back: Jacobian not clamped; seen to fail.
  for (double z = 1.0; z >= 0.2; z -= 0.05) {
    TestScene<float> scene = front_scene();
    add_round(scene, {12 * z, 0, z}, 0.1 * z / 0.25, 0.99, {1, 1, 1});
    for (const float c : render(scene, backend()).colour) ASSERT_EQ(c, 0.0f) << "z " << z;
  }
}

TEST_P(BackendFailures, BackgroundsDifferByTransmittance) {  // C14
  // Bug put back: the background added without T; seen to fail.
  TestScene<float> scene = front_scene();
  add_round(scene, {0, 0, 5}, 0.5, 0.7, {0.9, 0.1, 0.4});
  add_round(scene, {0.3, 0.1, 4}, 0.2, 0.4, {0.1, 0.8, 0.3});
  const Rendered<float> black = render(scene, backend());
  for (double& b : scene.options.background) b = 1;
  const Rendered<float> white = render(scene, backend());
  EXPECT_EQ(black.transmittance, white.transmittance);
  for (size_t i = 0; i < black.colour.size(); ++i)
    ASSERT_NEAR(white.colour[i] - black.colour[i],
                black.transmittance[i % (kFrontSize * kFrontSize)], 1e-6);
}

TEST_P(BackendFailures, LowDegreeEqualsHighDegreeWithZeroBands) {  // C15
  // Bug put back: one coefficient of the degree left out; seen to fail.
  for (int degree = 0; degree < 3; ++degree) {
    TestScene<float> scene = random_scene(15, 15, 0.2, 7).as<float>();
    scene.options.sh_degree = degree;
    const Rendered<float> low = render(scene, backend());
    const int kept = 3 * sh_coefficients(degree);
    for (TestGaussians<float>* set : {&scene.fixed, &scene.moving})
      for (int64_t n = 0; n < set->count; ++n) std::fill_n(set->at(kSh, n) + kept, 48 - kept, 0.0f);
    scene.options.sh_degree = 3;
    EXPECT_EQ(render(scene, backend()).colour, low.colour) << "degree " << degree;
  }
}

unsigned bits(std::initializer_list<Group> groups) {
  unsigned all = 0;
  for (const Group g : groups) all |= 1u << g;
  return all;
}

/// The groups reported when one splat's gradient has `spoil`ed fields and all others are zero.
unsigned groups_reported(const TestScene<float>& scene, Backend& backend,
                         const std::function<void(SplatMoments<float>&)>& spoil) {
  Memory& memory = backend.memory();
  const StoredScene<float> in(scene, memory);
  const ViewBatch<float> batch = make_view_batch<float>(scene.views);
  Splats<float> splats(memory);
  ProjectBackwardArgs<float> args;
  args.forward = {&batch, {in.sets[0].view(), in.sets[1].view()}, scene.options, true};
  backend.project(args.forward, splats);
  std::vector<SplatMoments<float>> d_splats(size_t(splats.count), SplatMoments<float>{});
  StoredGaussians<float> fixed(TestGaussians<float>(SetForm::kStatic, scene.fixed.count), memory);
  StoredGaussians<float> moving(TestGaussians<float>(SetForm::kPair, scene.moving.count), memory);
  args.splats = &splats;
  args.sinks[0].gradient = fixed.spans();
  args.sinks[1].gradient = moving.spans();
  Buffer<SplatMoments<float>> healthy = stored(d_splats, memory);
  args.d_splats = healthy.span();
  backend.project_backward(args);
  EXPECT_EQ(backend.outcome().bad_groups, 0u);
  spoil(d_splats[d_splats.size() / 2]);
  Buffer<SplatMoments<float>> spoilt = stored(d_splats, memory);
  args.d_splats = spoilt.span();
  backend.project_backward(args);
  return backend.outcome().bad_groups;
}

TEST_P(BackendFailures, NonFiniteGradientNamesItsGroups) {  // C20
  // Bugs put back, seen to fail: SH not tested; non_finite without the last group.
  const TestScene<float> still = random_scene(5, 0, 0.3, 6).as<float>();
  const TestScene<float> moving = random_scene(0, 5, 0.3, 6).as<float>();
  for (const float bad : {kNan, kInf}) {
    const auto opacity = [bad](SplatMoments<float>& d) { d.f = bad; };
    const auto position = [bad](SplatMoments<float>& d) { d.f_d[0] = bad; };
    const auto conic = [bad](SplatMoments<float>& d) { d.f_dd.xx = bad; };
    const auto colour = [bad](SplatMoments<float>& d) { d.colour = Vec3<float>(bad); };
    EXPECT_EQ(groups_reported(still, backend(), opacity), bits({kOpacityLogit}));
    EXPECT_EQ(groups_reported(still, backend(), position), bits({kMean}));
    EXPECT_EQ(groups_reported(still, backend(), conic), bits({kMean, kLogScale, kRotation}));
    EXPECT_EQ(groups_reported(still, backend(), colour), bits({kMean, kSh}));
    EXPECT_EQ(
        groups_reported(moving, backend(), opacity),
        bits({kOpacityLogit, kMeanTime, kLogScale, kLogScaleTime, kRotation, kRotationRight}));
  }
}

TEST_P(BackendFailures, NonFiniteImageGradientIsReportedOnceOnly) {  // C20
  // Bug put back: reported groups not reset; seen to fail.
  const TestScene<float> scene = random_scene(5, 5, 0.3, 7).as<float>();
  const auto result = backward<float>(scene, backend(), [](std::vector<float>& d) {
    for (float& x : d) x = kNan;
  });
  EXPECT_EQ(result.bad, (1u << kShTime) - 1) << "all that there are";
  EXPECT_EQ(backward(scene, backend()).bad, 0u);  // the groups were reset
}

}  // namespace
}  // namespace tessera::testing
