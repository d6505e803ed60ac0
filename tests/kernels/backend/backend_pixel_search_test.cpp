// The search of pixels on a device against the host's, to the bit: depths and motion at any pixel
// of rigs with masks, clocks and an odd size, and whole clouds.
#include "tests/ingest/cloud/host_search.h"

#include "ingest/cloud/initial_cloud.h"
#include "ingest/cloud/plane_sweep.h"
#include "ingest/cloud/still_pixels.h"
#include "tests/ingest/cloud/equal_clouds.h"
#include "tests/ingest/cloud/wall_scene.h"
#include "tests/support/backends.h"

namespace tessera::testing {
namespace {

class BackendPixelSearch : public DeviceOnly {};
TESSERA_ON_DEVICES(BackendPixelSearch);

constexpr DepthRange kRange{1 / 10.0, 1 / 0.625 - 1 / 10.0};  // of a wall at 3

/// Each frame against the others of its timestep, all times of its camera as sights.
std::vector<SearchView> views_of(const Scene& scene) {
  const StillPixels still(scene);
  std::vector<SearchView> views(scene.frames.size());
  for (size_t i = 0; i < views.size(); ++i) {
    const Frame& frame = scene.frames[i];
    SearchView& view = views[i];
    set_frame(frame, still, view);
    for (size_t k = 0; k < views.size() && view.other_count < kMostSights; ++k)
      if (k != i && scene.frames[k].timestep == frame.timestep)
        view.others[view.other_count++] = int(k);
  }
  return views;
}

void expect_host_results(PixelSearch& device, const Scene& scene, int step) {
  HostSearch host;
  const std::vector<SearchView> views = views_of(scene);
  host.set_views(views, kRange);
  device.set_views(views, kRange);
  std::vector<RayQuery> queries;
  std::vector<ViewPixel> pixels;
  for (int i = 0; i < int(views.size()); ++i)
    for (int y = 0; y < views[size_t(i)].image.height; y += step)
      for (int x = 0; x < views[size_t(i)].image.width; x += step) {
        pixels.push_back({i, x, y});
        queries.push_back({{i, x, y}, glm::dvec3(0.3 * (i % 3 - 1), 0, 0)});
      }
  const std::vector<RayDepth> expected = host.depths(queries), found = device.depths(queries);
  int64_t depths = 0, apart = 0;
  for (size_t i = 0; i < queries.size(); ++i) {
    depths += expected[i].inverse > 0;
    apart += found[i].inverse != expected[i].inverse || found[i].best != expected[i].best ||
             found[i].cost != expected[i].cost;
  }
  EXPECT_GT(depths, int64_t(queries.size()) / 10);
  EXPECT_EQ(apart, 0) << "of " << queries.size();
  const std::vector<uint8_t> moves = host.moves(pixels);
  EXPECT_EQ(device.moves(pixels), moves);
  EXPECT_GT(std::count(moves.begin(), moves.end(), 1), 10);
}

TEST_P(BackendPixelSearch, FindsWhatTheHostFinds) {
  const std::unique_ptr<PixelSearch> device = backend().pixel_search();
  ASSERT_NE(device, nullptr);
  Scene scene = wall_scene({.cameras = 10, .timesteps = 3, .size = 97, .apart = 0.1});
  expect_host_results(*device, scene, 3);
  std::vector<uint8_t> mask(97 * 97, 255);
  for (size_t i = 0; i < mask.size(); ++i) mask[i] = i % 97 < 40 ? 0 : 255;
  for (size_t i = 0; i < 6; ++i) scene.frames[i].mask = Image8{97, 97, 1, mask};
  expect_host_results(*device, scene, 3);
}

// Images change at the same place of the host's memory.
TEST_P(BackendPixelSearch, TakesTheImagesOfEachCall) {
  const std::unique_ptr<PixelSearch> device = backend().pixel_search();
  Scene scene = wall_scene({.cameras = 4, .timesteps = 3, .size = 64});
  std::vector<SearchView> views = views_of(scene);
  for (SearchView& view : views) view.sight_count = 0;
  const std::vector<RayQuery> queries(1, {{0, 30, 30}});
  device->set_views(views, kRange);
  EXPECT_GT(device->depths(queries)[0].inverse, 0);
  for (Frame& frame : scene.frames)
    std::fill(frame.image.data.begin(), frame.image.data.end(), uint8_t{90});
  device->set_views(views, kRange);
  EXPECT_EQ(device->depths(queries)[0].inverse, 0) << "without texture";
  EXPECT_TRUE(device->depths({}).empty());
  EXPECT_TRUE(device->moves({}).empty());
}

TEST_P(BackendPixelSearch, MakesTheCloudOfTheHost) {
  for (const double apart : {0.0, 0.13}) {
    const Scene scene = wall_scene({.cameras = 6, .timesteps = 9, .size = 128, .apart = apart});
    CloudOptions options;
    options.points = 3000;
    const RigCloud host = rig_cloud(SceneFrames(scene), options);
    const RigCloud device =
        rig_cloud(SceneFrames(scene), options, [&] { return backend().pixel_search(); });
    EXPECT_GT(host.velocities.moving, 50);
    expect_equal(device.points, host.points);
  }
}

}  // namespace
}  // namespace tessera::testing
