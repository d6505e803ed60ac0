// Masks of a capture: names, sizes, polarity, lenses, and the prepared scene made from them.
// Source: failure mode B17.
#include "ingest/steps/mask_source.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "ingest/files/png.h"
#include "ingest/layouts/mask_files.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;

/// `used(x, y)` of every pixel.
template <class Used>
Image8 mask_where(int width, int height, Used&& used) {
  Image8 mask{width, height, 1, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) mask.data.push_back(used(x, y) ? 255 : 0);
  return mask;
}
Image8 right_half(int width, int height) {
  return mask_where(width, height, [=](int x, int) { return x >= width / 2; });
}

class MaskSource : public ::testing::Test {
 protected:
  void SetUp() override {
    write_dnerf(folder_ / "capture", {});
    std::filesystem::create_directories(folder_ / "masks/train");
    options_.masks = folder_ / "masks";
  }
  void write(const std::string& name, const Image8& mask) {
    write_png(folder_ / ("masks/" + name), mask);
  }
  IngestReport ingest() {
    return ingest_capture(folder_ / "capture", folder_ / "scene", options_, {});
  }
  json prepared() const { return json::parse(read_bytes(folder_ / "scene/transforms.json")); }

  TemporaryFolder folder_;
  IngestOptions options_;
};

TEST_F(MaskSource, FoundByTheNameWithOrWithoutTheImagesExtension) {
  const auto found = [&](const char* image) { return MaskFiles(options_.masks).of_image(image); };
  EXPECT_EQ(found(""), "");
  EXPECT_EQ(found("train/a.jpg"), "");
  write_bytes(folder_ / "masks/train/A.JPG", "");
  EXPECT_EQ(found("train/a.jpg"), folder_ / "masks/train/A.JPG");
  write_bytes(folder_ / "masks/train/a.jpg", "");
  EXPECT_EQ(found("train/a.jpg"), folder_ / "masks/train/a.jpg");
  write_bytes(folder_ / "masks/train/a.png", "");
  EXPECT_EQ(found("train/a.jpg"), folder_ / "masks/train/a.png");
  write_bytes(folder_ / "masks/train/b.jpg.png", "");
  EXPECT_EQ(found("train/b.jpg"), folder_ / "masks/train/b.jpg.png");
}

// Bugs put back, each seen to fail: no inversion; the mask of the first frame stated for all.
TEST_F(MaskSource, PreparedSceneHasThemAndReportsIt) {
  const Image8 first = right_half(8, 6);
  const Image8 second = mask_where(8, 6, [](int x, int y) { return (x + 2 * y) % 3 > 0; });
  write("train/r_000.png", first);
  write("train/r_001.png.png", second);
  for (const bool inverted : {false, true}) {
    options_.invert_masks = inverted;
    ingest();
    const Scene scene = load_scene(folder_ / "scene", {});
    for (size_t p = 0; p < 48; ++p) {
      EXPECT_EQ(scene.frames[0].mask.data()[p], inverted ? 255 - first.data[p] : first.data[p]);
      EXPECT_EQ(scene.frames[1].mask.data()[p], inverted ? 255 - second.data[p] : second.data[p]);
    }
    for (size_t i = 2; i < 6; ++i) EXPECT_TRUE(scene.frames[i].mask.data().empty()) << i;
    const json file = prepared();
    EXPECT_EQ(file["frames"][0]["mask_path"], "masks/train/r_000.png");
    EXPECT_FALSE(file["frames"][2].contains("mask_path"));
  }
}

// Bug put back: masks of another size refused though the images were made smaller; seen to fail.
TEST_F(MaskSource, ScaledAsTheImagesAreAndCutAtOneHalf) {
  // of four pixels that become one, 0 to 3 are used, by column; and of the larger mask as many
  const auto share = [](int x, int y) { return 2 * (y % 2) + x % 2 < x / 2; };
  write("train/r_000.png", mask_where(8, 6, share));
  write("train/r_001.png", mask_where(16, 12, [&](int x, int y) { return share(x / 2, y / 2); }));
  options_.scale = 0.5;
  ingest();
  const Scene scene = load_scene(folder_ / "scene", {});
  for (const size_t i : {0u, 1u}) {
    ASSERT_EQ(scene.frames[i].mask.image().width, 4);
    for (int p = 0; p < 12; ++p)
      if (p % 4 != 2) {  // two of four: either
        EXPECT_EQ(scene.frames[i].mask.data()[size_t(p)], p % 4 == 3 ? 255 : 0) << i << " " << p;
      }
  }
}

// Bugs put back, each seen to fail: the same; the comparison of alpha_and_mask.cpp turned round.
TEST_F(MaskSource, MayBeAsLargeAsTheImagesOnceWere) {
  const auto pixel = [&](int width, int height, bool inverted) {
    write("train/r_000.png", right_half(width, height));
    options_.invert_masks = inverted;
    std::atomic<int64_t> object_masks{0};
    return read_mask(folder_ / "masks/train/r_000.png", 8, 6, options_, object_masks).data;
  };
  EXPECT_EQ(pixel(32, 24, false), right_half(8, 6).data);
  EXPECT_NE(pixel(32, 24, true), right_half(8, 6).data);
  expect_input_error([&] { pixel(24, 32, false); }, {"r_000.png", "24x32", "8x6"});
  expect_input_error([&] { pixel(4, 3, false); }, {"r_000.png", "4x3", "8x6"});
}

// Bug put back: the mask repeated beyond the border of the image; seen to fail.
TEST_F(MaskSource, WhatLiesBeyondADistortedImageIsIgnored) {
  const Camera camera{32, 24, 30, 30, 16, 12, {}, {}};
  Lens lens;
  lens.k1 = 0.05;
  Camera wider = camera;
  wider.fl_x = wider.fl_y = 20;  // sees beyond the image
  const Image8 mask =
      undistorted_mask(mask_where(32, 24, [](int, int) { return true; }), camera, lens, wider);
  int inside = 0, outside = 0;
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 32; ++x) {
      const glm::dvec2 met = lens.distorted({(x + 0.5 - 16) / 20, (y + 0.5 - 12) / 20});
      const double u = 30 * met.x + 16, v = 30 * met.y + 12;
      const double margin = std::min({u, 32 - u, v, 24 - v});  // pixels from the border, inwards
      if (std::abs(margin) < 0.1) continue;  // places are rounded to 1/32 of a pixel
      EXPECT_EQ(mask.data[size_t(y * 32 + x)], margin > 0 ? 255 : 0) << x << " " << y;
      ++(margin > 0 ? inside : outside);
    }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 100);
  EXPECT_EQ(undistorted_mask(mask, camera, {}, camera).data, mask.data);
}

}  // namespace
}  // namespace tessera
