// Clouds whose pixels are searched by a device are those of the CPU, to the bit.
#include <gtest/gtest.h>

#include "ingest/cloud/initial_cloud.h"
#include "tests/ingest/cloud/equal_clouds.h"
#include "tests/ingest/cloud/host_search.h"
#include "tests/ingest/cloud/wall_scene.h"

namespace tessera::testing {
namespace {

// Bugs put back: what moves and what does not changed over; one pixel a group; depths of the host's
// own images; each seen to fail.
TEST(DeviceSearch, FindsTheCloudOfTheHost) {
  for (const double apart : {0.0, 0.13}) {  // clocks that differ: motion is expected, too
    const Scene scene = wall_scene({.cameras = 6, .timesteps = 9, .apart = apart});
    CloudOptions options;
    options.points = 800;
    int64_t searched = 0;
    struct Noted : HostSearch {
      explicit Noted(int64_t& all) : all_(all) {}
      ~Noted() override { all_ = searched; }
      int64_t& all_;
    };
    const RigCloud by_host = rig_cloud(SceneFrames(scene), options);
    const RigCloud by_device =
        rig_cloud(SceneFrames(scene), options, [&] { return std::make_unique<Noted>(searched); });
    EXPECT_GT(by_host.velocities.moving, 50) << apart;
    EXPECT_GT(searched, 1000) << "by the device";
    expect_equal(by_device.points, by_host.points);
  }
}

// Bug put back: asked before it is known whether there is a rig; seen to fail.
TEST(DeviceSearch, IsNotAskedForWithoutARig) {
  const Scene scene = wall_scene({.cameras = 2, .timesteps = 9});
  bool asked = false;
  rig_cloud(SceneFrames(scene), {}, [&] {
    asked = true;
    return std::unique_ptr<PixelSearch>();
  });
  EXPECT_FALSE(asked);
}

}  // namespace
}  // namespace tessera::testing
