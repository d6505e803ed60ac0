// The fast scene: the distance that its objects move from frame to frame, the boxes around them,
// and the light and the gains of cameras in the images and in ground_truth.json.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "tests/support/scratch_folder.h"
#include "tools/synth/ground_truth.h"
#include "tools/synth/rigs.h"
#include "tools/synth/sensor.h"

namespace tessera::synth {
namespace {

using nlohmann::json;
using tessera::testing::ScratchFolder;

SynthOptions small_fast(int cameras, int frames) {
  SynthOptions options;
  options.scene = SynthScene::kFast;
  options.cameras = cameras;
  options.frames = frames;
  options.width = 120;
  options.height = 90;
  options.supersampling = 2;
  options.points = 50;
  return resolve_synth_options(options);
}

double middle(const PixelBox& box) {
  return 0.5 * (box.x0 + box.x1);
}

// Bugs put back, each seen to fail: no launch; a throw that continues after its end.
TEST(SynthFast, TheBallCrossesAThirdOfTheImageInTenFrames) {
  const SynthOptions options = small_fast(1, 48);
  const World world = build_world(options.scene, options.seed, 0);
  const Camera camera = video_rig(options, world.target).front();
  const StaticLayer layer = render_static(world, camera, 1);
  const auto box = [&](int frame) {
    return render(world, camera, normalised_time(options, frame), layer).boxes["thrown ball"];
  };
  EXPECT_NEAR(middle(box(22)) - middle(box(12)), options.width / 3.0, options.width / 12.0);
  EXPECT_LT(box(17).y1, box(8).y1) << "no higher than at its start";
  EXPECT_EQ(middle(box(0)), middle(box(6))) << "before the throw";
  EXPECT_EQ(middle(box(30)), middle(box(47))) << "after it";
}

// Bugs put back, each seen to fail: boxes that end at the last pixel; boxes of the ball about a
// mover, whatever hides it.
TEST(SynthFast, BoxesHoldWhatIsSeenOfEachMover) {
  const SynthOptions options = small_fast(3, 24);
  const World world = build_world(options.scene, options.seed, 0);
  for (const Camera& camera : video_rig(options, world.target)) {
    const StaticLayer layer = render_static(world, camera, options.supersampling);
    for (const double time : {0.1, 0.4, 0.75}) {
      const RenderedImage image = render(world, camera, time, layer);
      PixelBox joined, masked;
      for (const auto& [name, box] : image.boxes) joined.include(box);
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
          if (image.mask[size_t(y * image.width + x)] != 0) masked.include({x, y, x + 1, y + 1});
      EXPECT_EQ(std::tie(joined.x0, joined.y0, joined.x1, joined.y1),
                std::tie(masked.x0, masked.y0, masked.x1, masked.y1));
      World alone = world;  // without the other movers, which may hide it
      std::erase_if(alone.solids, [](const Solid& s) { return s.moves && s.name != "hand"; });
      const RenderedImage hand = render(alone, camera, time, layer);
      const PixelBox whole = hand.boxes.at("hand");
      int64_t inside = 0;
      for (int y = whole.y0; y < whole.y1; ++y)
        for (int x = whole.x0; x < whole.x1; ++x)
          inside += hand.mask[size_t(y * image.width + x)] != 0;
      EXPECT_EQ(inside, std::count(hand.mask.begin(), hand.mask.end(), 255));
    }
  }
}

// Bug put back: the flag behind the wall; seen to fail.
TEST(SynthFast, EveryMoverIsSeenByMostCameras) {
  const SynthOptions options = small_fast(8, 24);
  const World world = build_world(options.scene, options.seed, 0);
  std::map<std::string, int> cameras;
  for (const Camera& camera : video_rig(options, world.target))
    for (const auto& [name, box] : render(world, camera, 0.4, 1).boxes)
      cameras[name] += (box.x1 - box.x0) * (box.y1 - box.y0) > 20;
  for (const char* name : {"thrown ball", "returned ball", "upper arm", "forearm", "hand", "flag"})
    EXPECT_GE(cameras[name], 6) << name;
  EXPECT_EQ(cameras.size(), 6u);
}

// Bugs put back, each seen to fail: the step from the first frame on; the same gain of all
// channels; gains of cam00.
TEST(SynthFast, LightAndGainsOfCamerasAreInImagesAndTruth) {
  const ScratchFolder folder;
  SynthOptions options = small_fast(3, 8);
  options.light_step = 0.7;
  options.camera_gains = true;
  make_capture(options, folder / "fast", {});
  const json truth = json::parse(read_text_file(folder / "fast/ground_truth.json"));
  EXPECT_EQ(truth["options"]["light_step"], 0.7);
  EXPECT_EQ(truth["options"]["camera_gains"], true);
  EXPECT_EQ(truth["cameras"][0]["gain"], json({1, 1, 1}));
  RenderedImage grey{1, 1, {.5f, .5f, .5f, 1.f}, {0}, {0.f}};
  for (int camera = 0; camera < 3; ++camera) {
    const json& row = truth["cameras"][size_t(camera)];
    const json& boxes = row["boxes"]["flag"];
    ASSERT_EQ(boxes.size(), 8u);
    EXPECT_LT(boxes[3][0], boxes[3][2]);
    for (const int frame : {0, 3, 4, 7}) {
      const Image8 image = expose(grey, options, 3, camera, frame);
      for (size_t k = 0; k < 3; ++k) {
        const double gain = row["gain"][k];
        EXPECT_NEAR(image.data[k], 127.5 * gain * (frame < 4 ? 1 : 0.7), 0.51);
        if (camera == 0) continue;
        EXPECT_TRUE(gain >= 0.8 && gain < 1.2 && gain != 1) << gain;
        EXPECT_NE(gain, row["gain"][(k + 1) % 3]);
      }
    }
  }
  EXPECT_NE(truth["cameras"][1]["gain"], truth["cameras"][2]["gain"]);
}

TEST(SynthFast, LightAndGainsAreThoseOfARig) {
  const auto error_of = [](auto&& change) -> std::string {
    SynthOptions options;
    options.scene = SynthScene::kFast;
    change(options);
    try {
      resolve_synth_options(options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(error_of([](SynthOptions& o) { o.light_step = 0; }).find("light_step"),
            std::string::npos);
  for (const char* name : {"--light-step", "--camera-gains"}) {
    const std::string message = error_of([&](SynthOptions& o) {
      o.layout = SynthLayout::kDnerf;
      if (name[2] == 'l') o.light_step = 2;
      if (name[2] == 'c') o.camera_gains = true;
    });
    EXPECT_NE(message.find(name), std::string::npos) << message;
    EXPECT_NE(message.find("n3dv"), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace tessera::synth
