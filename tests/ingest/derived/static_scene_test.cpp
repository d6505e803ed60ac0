// The background that all windows of a long clip share: what is in it, what its masks leave out,
// and which captures have none.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>

#include "ingest/derived/static_scene.h"
#include "ingest/files/png.h"
#include "ingest/files/point_cloud.h"
#include "ingest/prepared/scene_reader.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera {
namespace {

using namespace tessera::testing;
using nlohmann::json;

constexpr int kWidth = 24, kHeight = 16, kMoments = 80;

/// Grey of a place that stands still.
uint8_t wall(int x, int y) {
  return uint8_t(60 + 5 * x + 3 * y);
}

/// A white ball of 3 × 3 crosses the upper rows of a wall; a box stands in the lower left until
/// three quarters of the clip are over, then in the lower right.
Image8 image_of(int frame) {
  Image8 image{kWidth, kHeight, 3, {}};
  const int ball = frame % kWidth, box = frame < 3 * kMoments / 4 ? 2 : 18;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const bool in_ball = y < 3 && x >= ball && x < ball + 3;
      const bool in_box = y >= 12 && x >= box && x < box + 3;
      const uint8_t grey = in_ball ? 255 : in_box ? 10 : wall(x, y);
      image.data.insert(image.data.end(), {grey, uint8_t(grey + frame % 3), grey});
    }
  return image;
}

class AStaticScene : public ::testing::Test {
 protected:
  void SetUp() override {
    for (int c = 0; c < 2; ++c)
      for (int i = 0; i < kMoments; ++i) add(c, i, image_of(i));
    Image8 mask{kWidth, kHeight, 1, std::vector<uint8_t>(size_t{kWidth} * kHeight, 255)};
    for (int y = 0; y < kHeight; ++y) mask.data[size_t(y * kWidth)] = 0;
    write_png(folder_ / "scene/masks/left.png", mask);
    write();
  }
  void add(int c, int i, const Image8& image) {
    const std::string name = fmt::format("cam{:02}/{:05}.png", c, i);
    write_png(folder_ / ("scene/" + name), image);
    frames_.push_back({{"file_path", name},
                       {"split", c == 0 ? "train" : "test"},
                       {"time", i / double(kMoments - 1)},
                       {"w", kWidth},
                       {"h", kHeight},
                       {"fl_x", 30},
                       {"fl_y", 30},
                       {"cx", 12},
                       {"cy", 8},
                       {"transform_matrix", gl_matrix(looking_at_origin({4.0 + c, 0.0, 0.0}))},
                       {"tessera", {{"camera", fmt::format("cam{:02}", c)}, {"frame", i}}}});
    if (c == 0) frames_.back()["mask_path"] = "masks/left.png";
  }
  void write() {
    const json tessera{
        {"format_version", 1},
        {"layout", "rig"},
        {"applied", {{"masks", "black ignored"}}},
        {"time", {{"base", {1, 30}}, {"origin", 3}, {"duration", 5.3}, {"static", false}}}};
    write_bytes(folder_ / "scene/transforms.json", json{{"camera_model", "PINHOLE"},
                                                        {"ply_file_path", "points.ply"},
                                                        {"tessera", tessera},
                                                        {"frames", frames_}}
                                                       .dump());
    write_points(folder_ / "scene/points.ply", points_);
  }
  StaticSceneReport make() {
    return write_static_scene(folder_ / "scene", folder_ / "static", [](int64_t, int64_t) {});
  }
  Scene read() const {
    SceneOptions options;
    options.allow_static = true;
    return load_scene(folder_ / "static", options);
  }

  TemporaryFolder folder_;
  json frames_ = json::array();
  PointCloud points_{
      {{0, 0, 0}, {0, 0, 0.1F}, {0, 100, 0}}, {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}, {}, {1, 0, 1}};
};

// Bugs put back, each seen to fail: quarters that differ as they like (the box that is moved
// stays); the first image instead of the median (the ball); masks of the scene that are dropped.
TEST_F(AStaticScene, HasWhatStaysAndMasksWhatIsMoved) {
  const StaticSceneReport report = make();
  EXPECT_EQ(report.cameras, 2);
  EXPECT_TRUE(report.warnings.empty());
  const Scene scene = read();
  EXPECT_TRUE(scene.is_static);
  EXPECT_EQ(scene.static_of, kMoments);
  EXPECT_EQ(scene.time_axis.origin, 3);
  ASSERT_EQ(scene.frames.size(), 2u);
  EXPECT_EQ(scene.frames[0].split, Split::kTrain);
  EXPECT_EQ(scene.frames[1].split, Split::kTest);
  int64_t shared = 0, used = 0;
  for (const Frame& frame : scene.frames)
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const bool is_masked = frame.camera_name == "cam00" && x == 0;
        const bool moved = y >= 12 && ((x >= 2 && x < 5) || (x >= 18 && x < 21));
        EXPECT_EQ(frame.mask.ignores(x, y), is_masked || moved) << x << " " << y;
        used += !is_masked;
        shared += !is_masked && !moved;
        if (moved) continue;
        EXPECT_EQ(int(frame.image.data[3 * size_t(y * kWidth + x)]), int(wall(x, y)));
      }
  EXPECT_NEAR(report.shared, double(shared) / double(used), 1e-12);
}

// Masks of single frames, as programs of segmentation write them. Finds: the mask of the first
// frame for all; what a mask ignores in the background.
TEST_F(AStaticScene, CountsImagesWhoseMaskUsesThePixel) {
  const auto masked = [&](const std::string& name, int from, int to) {
    Image8 mask{kWidth, kHeight, 1, std::vector<uint8_t>(size_t{kWidth} * kHeight, 255)};
    for (int y = 0; y < kHeight; ++y)
      for (int x = from; x < to; ++x) mask.data[size_t(y * kWidth + x)] = 0;
    write_png(folder_ / ("scene/masks/" + name), mask);
    return "masks/" + name;
  };
  const std::string most = masked("most.png", 4, kWidth), left = masked("l.png", 0, 8),
                    none = masked("none.png", 0, 0);
  // the second camera: most of its first frame is ignored; the left of all others but ten is
  for (int i = 0; i < kMoments; ++i)
    frames_[size_t(kMoments + i)]["mask_path"] = i == 0 ? most : i % 8 == 0 ? none : left;
  write();
  make();
  const Scene scene = read();
  for (int y = 4; y < 11; ++y)
    for (int x = 0; x < kWidth; ++x)
      EXPECT_EQ(scene.frames[1].mask.ignores(x, y), x < 8) << x << " " << y;
}

// A figure that moves on one spot has the same medians in all quarters; noise alone moves nothing.
// Bugs put back, each seen to fail: the figure in the background; noise of 15 levels that passes
// for movement within a quarter; between quarters.
TEST_F(AStaticScene, LeavesOutWhatMovesOnOneSpot) {
  const auto is_figure = [](int x, int y) { return y >= 6 && y < 10 && x >= 9 && x < 14; };
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 15);
  for (int i = 0; i < kMoments; ++i)
    for (int c = 0; c < 2; ++c) {
      Image8 image = image_of(i);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
          for (int v = 0; v < 3; ++v) {
            uint8_t& value = image.data[size_t(3 * (y * kWidth + x) + v)];
            double now = is_figure(x, y) ? 20 + 50 * ((3 * i + x) % 5) : value;
            if (c == 1) now += noise(random);
            value = uint8_t(std::clamp(now, 0.0, 255.0));
          }
      write_png(folder_ / fmt::format("scene/cam{:02}/{:05}.png", c, i), image);
    }
  make();
  const Scene scene = read();
  for (const Frame& frame : scene.frames) {
    int still = 0, masked = 0;
    for (int y = 4; y < 12; ++y)
      for (int x = 1; x < kWidth; ++x) {
        if (is_figure(x, y))
          EXPECT_TRUE(frame.mask.ignores(x, y)) << frame.camera_name << " " << x << " " << y;
        else
          ++(frame.mask.ignores(x, y) ? masked : still);
      }
    EXPECT_LE(masked, frame.camera_name == "cam00" ? 0 : still / 10);
  }
}

// What is hidden half of the time, by things of many colours, is still the background; a light that
// is on for half of the time has none. Bugs put back, each seen to fail: medians, which are no
// colour of either; a second colour that does not count; one image instead of the mean of those
// that are alike.
TEST_F(AStaticScene, HasTheMostFrequentColourOfWhatIsOftenHidden) {
  const auto is_hidden = [](int x, int y) { return y >= 5 && y < 8 && x >= 4 && x < 20; };
  const auto is_light = [](int x, int y) { return y >= 9 && y < 11 && x >= 4 && x < 8; };
  std::mt19937 random(1);
  for (int i = 0; i < kMoments; ++i) {
    Image8 image = image_of(i);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        uint8_t* value = &image.data[size_t(3 * (y * kWidth + x))];
        if (is_light(x, y) && random() % 2 == 0) std::fill_n(value, 3, uint8_t{250});
        if (!is_hidden(x, y)) continue;
        const bool is_seen = random() % 20 < 10;
        for (int v = 0; v < 3; ++v)
          value[v] = uint8_t(is_seen ? wall(x, y) + int(random() % 7) - 3 : random() % 256);
      }
    write_png(folder_ / fmt::format("scene/cam00/{:05}.png", i), image);
    write_png(folder_ / fmt::format("scene/cam01/{:05}.png", i), image);
  }
  make();
  int hidden = 0, kept = 0, lit = 0, lights = 0;
  for (const Frame& frame : read().frames)
    for (int y = 5; y < 11; ++y)
      for (int x = 1; x < kWidth; ++x) {
        const bool masked = frame.mask.ignores(x, y);
        lights += is_light(x, y);
        lit += is_light(x, y) && !masked;
        hidden += is_hidden(x, y);
        if (!is_hidden(x, y) || masked) continue;
        ++kept;
        EXPECT_NEAR(frame.image.data[3 * size_t(y * kWidth + x)], wall(x, y), 2) << x << " " << y;
      }
  EXPECT_GE(kept, hidden * 8 / 10);
  EXPECT_LE(lit, lights / 5);
}

// Bug put back: images at equal distances, at which what repeats in that time is always in one
// place and is taken for background; seen to fail.
TEST_F(AStaticScene, LeavesOutWhatMovesInTimeWithTheChosenImages) {
  constexpr int kPeriod = 4, kLong = 4 * (30 * kPeriod + 1);  // 31 images of a quarter, 4 apart
  const auto first = [](int frame) { return frame % kPeriod < kPeriod / 2 ? 5 : 15; };
  frames_ = json::array();
  for (int i = 0; i < kLong; ++i) {
    Image8 image{kWidth, kHeight, 3, {}};
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const bool in_box = y >= 5 && y < 9 && x >= first(i) && x < first(i) + 4;
        image.data.insert(image.data.end(), 3, in_box ? 255 : wall(x, y));
      }
    add(0, i, image);
    frames_.back()["time"] = i / double(kLong - 1);
  }
  write();
  make();
  const Frame frame = read().frames.at(0);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 1; x < kWidth; ++x) {
      const bool moves = y >= 5 && y < 9 && ((x >= 5 && x < 9) || (x >= 15 && x < 19));
      EXPECT_EQ(frame.mask.ignores(x, y), moves) << x << " " << y;
    }
}

// Light that changes over all of an image is no movement; the background is in that of the first
// quarter. Bugs put back, each seen to fail: images that are compared as they are.
TEST_F(AStaticScene, IsInOneLight) {
  const auto light_of = [](int i) { return (i < kMoments / 2 ? 1.0 : 0.8) + 0.05 * (i % 2); };
  for (int i = 0; i < kMoments; ++i)
    for (int c = 0; c < 2; ++c) {
      Image8 image = image_of(i);
      for (size_t v = 0; v < image.data.size(); ++v)
        image.data[v] = uint8_t(std::min(255.0, image.data[v] * light_of(i) * (v % 3 ? 1 : 0.9)));
      write_png(folder_ / fmt::format("scene/cam{:02}/{:05}.png", c, i), image);
    }
  const StaticSceneReport report = make();
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_GT(report.shared, 0.9);
  for (const Frame& frame : read().frames)
    for (int y = 4; y < 11; ++y)
      for (int x = 1; x < kWidth; ++x) {
        EXPECT_FALSE(frame.mask.ignores(x, y)) << x << " " << y;
        EXPECT_NEAR(frame.image.data[3 * size_t(y * kWidth + x) + 2], 1.02 * wall(x, y), 5);
      }
}

// Bug put back: points that move; seen to fail. Finds also: points that no image shows; times of
// points, which a static cloud lacks.
TEST_F(AStaticScene, HasThePointsThatStandStillAndAreShown) {
  make();
  const Scene scene = read();
  ASSERT_EQ(scene.points.position.size(), 1u);
  EXPECT_EQ(scene.points.colour[0], (std::array<uint8_t, 3>{1, 2, 3}));
  EXPECT_TRUE(scene.points.time.empty());
}

// Bugs put back, each seen to fail: nothing said of light that changes; quarters that differ as
// they like. Finds also: a camera that moves; a clip too short to tell.
TEST_F(AStaticScene, IsRefusedOrWarnedOfWhereThereIsNone) {
  for (int i = 0; i < kMoments; ++i) {
    Image8 image = image_of(i);
    for (size_t v = 0; v < image.data.size(); ++v)  // a shadow that moves on
      image.data[v] = uint8_t(image.data[v] * (int(v / 3) % kWidth < i / 3 ? 0.7 : 1));
    write_png(folder_ / fmt::format("scene/cam00/{:05}.png", i), image);
    write_png(folder_ / fmt::format("scene/cam01/{:05}.png", i), image);
  }
  const std::vector<std::string> warnings = make().warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("of the pixels look the same"), std::string::npos);

  frames_[7]["transform_matrix"] = gl_matrix(looking_at_origin({4.0, 1.0, 0.0}));
  write();
  expect_input_error([&] { make(); }, {"cam00 moves", "fixed cameras"});
  frames_.erase(frames_.begin() + 11, frames_.end());
  frames_.erase(frames_.begin() + 7);
  write();
  expect_input_error([&] { make(); }, {"10 frames", "needs 12"});
  EXPECT_TRUE(std::filesystem::exists(folder_ / "static/transforms.json")) << "nothing is lost";
  expect_input_error([&] { write_static_scene(folder_.path(), folder_ / "x", {}); },
                     {"no prepared scene"});
}

}  // namespace
}  // namespace tessera
