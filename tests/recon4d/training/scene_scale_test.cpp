// Smaller images of a scene: means of areas, cameras with the same field of view, masks.
#include "recon4d/training/scene_scale.h"

#include <gtest/gtest.h>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

Image8 grey(int width, int height, std::vector<uint8_t> data) {
  return {width, height, 1, std::move(data)};
}

// Bugs put back, each seen to fail: nearest pixels; shares of pixels at an edge taken as whole.
TEST(SceneScale, PixelsAreMeansOfTheirAreas) {
  EXPECT_EQ(averaged_image(grey(4, 2, {0, 10, 20, 30, 4, 14, 24, 34}), 2, 1).data,
            (std::vector<uint8_t>{7, 27}));
  // 3 → 2: 2/3 of a whole pixel and 1/3 of the one between
  EXPECT_EQ(averaged_image(grey(3, 1, {30, 90, 150}), 2, 1).data, (std::vector<uint8_t>{50, 130}));
  EXPECT_EQ(averaged_image(grey(1, 3, {30, 90, 150}), 1, 2).data, (std::vector<uint8_t>{50, 130}));
  EXPECT_EQ(averaged_image(grey(2, 1, {0, 1}), 1, 1).data, (std::vector<uint8_t>{1}));  // 0.5
  const Image8 rgb{2, 1, 3, {10, 20, 30, 20, 40, 60}};
  EXPECT_EQ(averaged_image(rgb, 1, 1).data, (std::vector<uint8_t>{15, 30, 45}));
  const Image8 white{7, 5, 1, std::vector<uint8_t>(35, 255)};
  for (const uint8_t value : averaged_image(white, 3, 4).data) EXPECT_EQ(value, 255);
}

// Bugs put back, each seen to fail: the camera left at its size; pixels used where any of their
// area is.
TEST(SceneScale, CamerasSeeTheSame) {
  Scene scene;
  Frame frame;
  frame.image = grey(10, 6, std::vector<uint8_t>(60, 9));
  Image8 mask = grey(10, 6, std::vector<uint8_t>(60, 255));
  mask.data[12] = 0;  // x 2, y 1
  frame.mask = std::move(mask);
  frame.camera.width = 10;
  frame.camera.height = 6;
  frame.camera.fl_x = 8;
  frame.camera.fl_y = 9;
  frame.camera.cx = 5;
  frame.camera.cy = 2;
  scene.frames.push_back(frame);
  const Frame half = scaled_scene(scene, 0.5).frames[0];
  EXPECT_EQ(half.image.width, 5);
  EXPECT_EQ(half.camera.height, 3);
  EXPECT_EQ(half.camera.fl_x, 4);
  EXPECT_EQ(half.camera.cy, 1);
  for (int i = 0; i < 15; ++i) EXPECT_EQ(half.mask.data()[size_t(i)], i == 1 ? 0 : 255) << i;
  EXPECT_EQ(scaled_scene(scene, 1).frames[0].image.data, frame.image.data);
  EXPECT_EQ(scaled_scene(scene, 0.01).frames[0].image.data.size(), 1u);
}

// Bugs put back, each seen to fail: a mask scaled for each frame; one mask for all.
TEST(SceneScale, FramesOfOneMaskShareItScaled) {
  const FrameMask left = grey(4, 2, {255, 255, 0, 0, 255, 255, 0, 0});
  const FrameMask right = grey(4, 2, {0, 0, 255, 255, 0, 0, 255, 255});
  Scene scene;
  for (const FrameMask& mask : {left, right, left, FrameMask()}) {
    Frame& frame = scene.frames.emplace_back();
    frame.image = grey(4, 2, std::vector<uint8_t>(8, 9));
    frame.mask = mask;
  }
  const std::vector<Frame> half = scaled_scene(scene, 0.5).frames;
  EXPECT_EQ(half[0].mask.data(), (std::vector<uint8_t>{255, 0}));
  EXPECT_EQ(half[1].mask.data(), (std::vector<uint8_t>{0, 255}));
  EXPECT_EQ(half[2].mask.shared(), half[0].mask.shared());
  EXPECT_EQ(half[3].mask.shared(), nullptr);
}

// Bug put back: an image that is not loaded averaged; seen to fail.
TEST(SceneScale, ImagesThatAreNotLoadedKeepTheirSize) {
  Scene scene;
  scene.frames.resize(1);
  scene.frames[0].image = {40, 20, 3, {}};
  const Image8 half = scaled_scene(scene, 0.5).frames[0].image;
  EXPECT_EQ(half.width, 20);
  EXPECT_TRUE(half.data.empty());
}

TEST(SceneScale, TruthIsNeverInvented) {
  EXPECT_EQ(truth_scale(2, 0.5), 1);
  EXPECT_EQ(truth_scale(0.5, 0.5), 0.25);
  EXPECT_THROW(truth_scale(2, 1), InputError);
  EXPECT_THROW(truth_scale(4, 0.5), InputError);
}

}  // namespace
}  // namespace tessera
