// Splats, instance lists and images of every backend against the CPU oracle in double and against
// the formulas. Source: failure modes C1, C8.
#include <iterator>
#include <set>

#include "kernels/math/sort_keys.h"
#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/backends.h"
#include "tests/support/stage_run.h"

namespace tessera::testing {
namespace {

class BackendForward : public EveryBackend {
 protected:
  void expect_images(const TestScene<double>& scene) {
    const Rendered<float> actual = render(scene.as<float>(), backend());
    const Rendered<double> expected = render(scene);
    expect_batch(actual.colour, actual.transmittance, expected, critical_pixels(scene));
    // a splat may lie within rounding of an edge of the image, an ellipse of that of a tile
    const auto near = [](int64_t a, int64_t b) { return std::abs(a - b) <= 1 + b / 500; };
    EXPECT_PRED2(near, actual.report.splats, expected.report.splats);
    EXPECT_PRED2(near, actual.report.instances, expected.report.instances);
    EXPECT_EQ(actual.report.invalid_gaussians, 0);
  }
};
TESSERA_ON_EVERY_BACKEND(BackendForward);

TEST_P(BackendForward, ImagesOfThreeViews) {
  // Bugs put back, each seen to fail: all stored bands drawn whatever the degree; means 1e-5 off;
  // the background not dimmed.
  for (const SceneCase& c : kSceneCases) {
    SCOPED_TRACE(c.name);
    expect_images(scene_of(c, 1));
  }
}

TEST_P(BackendForward, ImagesOfOneViewAndOfFive) {
  // Bug put back: the fifth view left out; seen to fail.
  TestScene<double> scene = random_scene(80, 80, 0.2, 2);
  set_views(scene, {three_views()[1]}, 3);
  expect_images(scene);
  set_views(scene, five_views(), 3);
  expect_images(scene);
}

TEST_P(BackendForward, ImagesLargerThanTheBlocksOfAnyStage) {
  // Bug put back: two splats exchanged in the order of depth; seen to fail.
  TestScene<double> scene = random_scene(700, 900, 0.1, 4);
  std::vector<View> views = three_views();
  for (View& view : views)
    view.camera = view.camera.resized(3 * view.camera.width, 3 * view.camera.height);
  set_views(scene, views, 5);
  expect_images(scene);
}

TEST_P(BackendForward, ImagesWhereManyOpaqueLayersStopTheLight) {
  // Bug put back: the stop tested before blending; seen to fail.
  TestScene<double> scene = random_scene(300, 200, 0.4, 6);
  for (double& logit : scene.fixed.group[kOpacityLogit]) logit = 4;
  expect_images(scene);
}

TEST_P(BackendForward, ZeroGaussiansInEitherOrBothSets) {  // C1
  // Bug put back: tiles without instances not stored; seen to fail.
  for (const auto& [fixed, moving] : {std::pair{0, 0}, {40, 0}, {0, 40}}) {
    SCOPED_TRACE(fixed);
    const TestScene<double> scene = random_scene(fixed, moving, 0.2, 7);
    expect_images(scene);
    const Backward<float> result = backward(scene.as<float>(), backend());
    EXPECT_EQ(result.bad, 0u);
    if (fixed + moving > 0) continue;
    EXPECT_EQ(result.rendered.report.splats, 0);
    size_t i = 0;
    for (const View& view : scene.views)
      for (int c = 0; c < 3; ++c)
        for (int p = 0; p < view.camera.width * view.camera.height; ++p)
          ASSERT_EQ(result.rendered.colour[i++], float(scene.options.background[c]));
    for (const float T : result.rendered.transmittance) ASSERT_EQ(T, 1.0f);
    for (const int32_t used : result.rendered.used) ASSERT_EQ(used, 0);
  }
}

/// A field of every splat, by key.
template <class Real, class Field>
std::map<int64_t, double> by_key(const StageRun<Real>& run, Field&& field) {
  const std::vector<int64_t> keys = run.keys();
  std::map<int64_t, double> values;
  for (size_t s = 0; s < keys.size(); ++s) values[keys[s]] = double(field(run, s));
  return values;
}

template <class Field>
void expect_field(const StageRun<float>& actual, const StageRun<double>& expected, double share,
                  const char* what, Field&& field) {
  const auto a = by_key(actual, field), e = by_key(expected, field);
  double scale = 0, worst = 0, total = 0, sum = 0;
  for (const auto& [key, value] : e) {
    scale = std::max(scale, std::abs(value));
    const auto found = a.find(key);
    if (found == a.end()) continue;
    worst = std::max(worst, std::abs(found->second - value));
    sum += found->second - value;
    total += std::abs(value);
  }
  EXPECT_LE(worst, share * scale) << what;
  EXPECT_LE(std::abs(sum), share * total) << what << ": bias";
}

TEST_P(BackendForward, SplatsEqualTheOracles) {
  // Bug put back: means 1e-5 off; seen to fail.
  const TestScene<double> scene = random_scene(150, 150, 0.15, 8);
  const StageRun<float> actual = run_stages(scene.as<float>(), backend());
  CpuBackend<double> oracle;
  const StageRun<double> expected = run_stages(scene, oracle);
  std::set<int64_t> drawn, wanted, apart;
  for (const int64_t key : actual.keys()) drawn.insert(key);
  for (const int64_t key : expected.keys()) wanted.insert(key);
  std::set_symmetric_difference(drawn.begin(), drawn.end(), wanted.begin(), wanted.end(),
                                std::inserter(apart, apart.end()));
  EXPECT_LE(apart.size(), 1u);
  EXPECT_EQ(drawn.size(), actual.splat.size());  // no splat twice
  // float's rounding times the some ten operations of a projection; of a conic, times its condition
  constexpr double kShare = 3e-6, kConic = 3e-5;
  expect_field(actual, expected, kShare, "depth", [](auto& r, size_t s) { return r.depth[s]; });
  for (int k = 0; k < 2; ++k)
    expect_field(actual, expected, kShare, "mean2d",
                 [k](auto& r, size_t s) { return r.splat[s].mean2d[k]; });
  expect_field(actual, expected, kConic, "conic.xx",
               [](auto& r, size_t s) { return r.splat[s].conic.xx; });
  expect_field(actual, expected, kConic, "conic.xy",
               [](auto& r, size_t s) { return r.splat[s].conic.xy; });
  expect_field(actual, expected, kConic, "conic.yy",
               [](auto& r, size_t s) { return r.splat[s].conic.yy; });
  expect_field(actual, expected, kShare, "opacity",
               [](auto& r, size_t s) { return r.splat[s].opacity; });
  expect_field(actual, expected, kShare, "power",
               [](auto& r, size_t s) { return r.splat[s].power; });
  for (int c = 0; c < 3; ++c)
    expect_field(actual, expected, kShare, "colour",
                 [c](auto& r, size_t s) { return r.splat[s].colour[c]; });
}

TEST_P(BackendForward, LastBlendedSplatIsTheOracles) {
  // Bug put back: the place without the 1; seen to fail.
  const TestScene<double> scene = random_scene(150, 150, 0.3, 9);
  const std::vector<int64_t> actual = run_stages(scene.as<float>(), backend()).last_drawn();
  CpuBackend<double> oracle;
  const std::vector<int64_t> expected = run_stages(scene, oracle).last_drawn();
  ASSERT_EQ(actual.size(), expected.size());
  const auto masks = critical_pixels(scene);
  size_t p = 0;
  for (const std::vector<bool>& mask : masks)
    for (const bool critical : mask) {
      if (!critical) {
        ASSERT_EQ(actual[p], expected[p]) << "pixel " << p;
      }
      ++p;
    }
}

/// How far inside the splat's reach a tile is: > 0 reached, < 0 not, in units of the power.
double margin(const Splat<float>& s, int x, int y) {
  const Vec2<double> mean(s.mean2d[0], s.mean2d[1]);
  const Sym2<double> conic{s.conic.xx, s.conic.xy, s.conic.yy};
  return 1 - least_power_in(mean, conic, x * kTileSize + 0.5, y * kTileSize + 0.5, 15.0, 15.0) /
                 double(s.power);
}

bool holds(const TileRect& rect, int x, int y) {
  return x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1;
}

TEST_P(BackendForward, ListsHoldTheSplatsThatReachATileFrontToBack) {  // C8
  // Bugs put back, seen to fail: every 97th place not written; instances counted one short.
  const TestScene<float> scene = random_scene(250, 250, 0.25, 10).as<float>();
  const float near_plane = float(scene.options.near_plane);
  const StageRun<float> run = run_stages(scene, backend());
  ASSERT_EQ(int64_t(run.tile_begin.size()), run.batch.tiles + 1);
  EXPECT_EQ(run.tile_begin.front(), 0);
  EXPECT_EQ(run.tile_begin.back(), run.instances);
  std::vector<int32_t> listed(run.splat.size(), 0);
  for (size_t b = 0; b < run.batch.views.size(); ++b)
    for (int tile = 0; tile < run.batch.views[b].tiles_x * run.batch.views[b].tiles_y; ++tile) {
      const int x = tile % run.batch.views[b].tiles_x, y = tile / run.batch.views[b].tiles_x;
      const size_t t = size_t(run.batch.views[b].first_tile + tile);
      std::set<int32_t> here;
      for (int64_t i = run.tile_begin[t]; i < run.tile_begin[t + 1]; ++i) {
        const int32_t s = run.instance_splat[size_t(i)];
        ASSERT_TRUE(s >= 0 && s < run.splats) << "poison left at " << i;
        ASSERT_EQ(run.splat[size_t(s)].view, int32_t(b));
        ASSERT_TRUE(here.insert(s).second) << "twice in a list";
        ASSERT_TRUE(holds(run.rect[size_t(s)], x, y)) << "splat " << s << " tile " << tile;
        ++listed[size_t(s)];
        if (i == run.tile_begin[t]) continue;
        const int32_t before = run.instance_splat[size_t(i - 1)];
        const auto place = [&](int32_t splat) {
          return std::pair(depth_key(run.depth[size_t(splat)], near_plane), splat);
        };
        ASSERT_LT(place(before), place(s));
      }
      for (int32_t s = 0; s < run.splats; ++s) {
        if (run.splat[size_t(s)].view != int32_t(b) || here.count(s) > 0) continue;
        ASSERT_LE(margin(run.splat[size_t(s)], x, y), 1e-4) << "splat " << s << " tile " << tile;
        ASSERT_FALSE(holds(run.rect[size_t(s)], x, y)) << "splat " << s << " tile " << tile;
      }
    }
  EXPECT_EQ(listed, run.tiles);  // counted = filled
}

TEST_P(BackendForward, SlotsLeadFromASplatToItsInstances) {
  // Bug put back: all instances of a splat in its first slot; seen to fail.
  TestScene<float> scene = random_scene(150, 150, 0.3, 11).as<float>();
  scene.options.kernels.deterministic = true;  // then every backend needs them
  const StageRun<float> run = run_stages(scene, backend());
  ASSERT_EQ(int64_t(run.slot.size()), run.instances);
  std::vector<int> visits(run.slot.size(), 0);
  for (size_t s = 0; s < run.splat.size(); ++s)
    for (int32_t k = 0; k < run.tiles[s]; ++k) {
      const int64_t place = run.slot[size_t(run.first_slot[s] + k)];
      ASSERT_EQ(run.instance_splat[size_t(place)], int32_t(s));
      ++visits[size_t(place)];
    }
  EXPECT_EQ(visits, std::vector<int>(visits.size(), 1));
}

TEST_P(BackendForward, EqualDepthsKeepTheOrderOfGaussians) {
  // Bug put back: an unstable sort; seen to fail.
  // a wall of Gaussians at one depth before a camera along z: the first one is in front
  TestScene<double> scene = random_scene(120, 0, 0.3, 12);
  View view;
  view.camera.width = 40;
  view.camera.height = 33;
  view.camera.fl_x = view.camera.fl_y = 40;
  view.camera.cx = 20;
  view.camera.cy = 16;
  for (int64_t n = 0; n < 120; ++n) scene.fixed.at(kMean, n)[2] = 3;
  set_views(scene, {view}, 13);
  const StageRun<float> run = run_stages(scene.as<float>(), backend());
  for (const float depth : run.depth) ASSERT_EQ(depth, 3.0f);
  for (int64_t t = 0; t < run.batch.tiles; ++t)
    for (int64_t i = run.tile_begin[size_t(t)] + 1; i < run.tile_begin[size_t(t) + 1]; ++i)
      ASSERT_LT(run.instance_splat[size_t(i - 1)], run.instance_splat[size_t(i)]);
  expect_images(scene);
}

}  // namespace
}  // namespace tessera::testing
