// The supply of frames to a training: from host memory, all at once, or by a ring buffer ahead of
// the steps.
#include <gtest/gtest.h>

#include "kernels/base/errors.h"
#include "kernels/math/photometric.h"
#include "recon4d/training/batch_sampler.h"
#include "recon4d/training/frame_cache.h"
#include "recon4d/training/stage_bench.h"
#include "tests/support/separate_backend.h"

namespace tessera::testing {
namespace {

constexpr int kFrames = 11;

/// Frames of different sizes, each filled with a pattern of its own; every third is not trained on.
/// Every second has a mask.
Scene patterned() {
  Scene scene;
  for (int i = 0; i < kFrames; ++i) {
    Frame frame;
    frame.image = {5 + i % 3, 4, 3, {}};
    for (int k = 0; k < 3 * frame.image.width * 4; ++k)
      frame.image.data.push_back(uint8_t(17 * i + k));
    Image8 mask{frame.image.width, 4, 1, {}};
    for (int k = 0; k < mask.width * mask.height; ++k)
      mask.data.push_back((5 * i + k) % 3 == 0 ? 255 : 0);
    if (i % 2 == 0) frame.mask = std::move(mask);
    scene.frames.push_back(std::move(frame));
  }
  return scene;
}
std::vector<int> trained() {
  return {0, 1, 3, 4, 6, 7, 9, 10};
}
constexpr int64_t kTrained = 8;
constexpr int64_t kMasked = 4;  // of the trained ones: 0, 4, 6, 10

const Frame& frame_of(const Scene& scene, int64_t index) {
  return scene.frames[size_t(trained()[size_t(index)])];
}

/// Copies that bring a batch over: one an image, one a mask.
int64_t copies_of(const Scene& scene, const std::vector<int64_t>& indices) {
  int64_t copies = 0;
  for (const int64_t index : indices) copies += frame_of(scene, index).mask.data().empty() ? 1 : 2;
  return copies;
}

// Bugs put back, each seen to fail: masks of a slot not copied; masks taken from the batch's first
// frame; the place of a frame in a slot counted without the masks before it.
void expect_frames(SeparateMemory& memory, const Scene& scene, const TargetImages& supplied,
                   const std::vector<int64_t>& indices) {
  ASSERT_EQ(supplied.images.size(), indices.size());
  ASSERT_EQ(supplied.masks.size(), indices.size());
  memory.inside([&] {
    for (size_t b = 0; b < indices.size(); ++b) {
      const Frame& frame = frame_of(scene, indices[b]);
      const Span<const uint8_t>&image = supplied.images[b], &mask = supplied.masks[b];
      EXPECT_EQ(std::vector<uint8_t>(image.begin(), image.end()), frame.image.data) << b;
      EXPECT_EQ(std::vector<uint8_t>(mask.begin(), mask.end()), frame.mask.data()) << b;
      EXPECT_EQ(mask.data == nullptr, frame.mask.data().empty()) << b;
    }
  });
}

TEST(FrameCache, OnTheHostNothingIsCopied) {
  const Scene scene = patterned();
  FrameCache feed(host_memory(), scene, trained(), 0, 2);
  const TargetImages supplied = feed.truth({3, 0, 1});
  EXPECT_EQ(supplied.images[0].data, scene.frames[4].image.data.data());
  EXPECT_EQ(supplied.images[1].data, scene.frames[0].image.data.data());
  EXPECT_EQ(supplied.masks[1].data, scene.frames[0].mask.data().data());
  EXPECT_TRUE(supplied.masks[2].empty());
  EXPECT_EQ(feed.ahead(), 0);
}

TEST(FrameCache, WhatFitsIsBroughtOverOnce) {
  const Scene scene = patterned();
  SeparateMemory memory;
  FrameCache feed(memory, scene, trained(), 0, 3);
  EXPECT_EQ(memory.async_copies, kTrained + kMasked);
  EXPECT_EQ(feed.ahead(), 0);
  for (const std::vector<int64_t>& batch : {std::vector<int64_t>{0, 1, 2}, {7, 7, 3}, {5, 6, 4}})
    expect_frames(memory, scene, feed.truth(batch), batch);
  EXPECT_EQ(memory.async_copies, kTrained + kMasked);
}

// Bug put back: masks of the frames; seen to fail.
TEST(FrameCache, GivenMasksTakeThePlaceOfTheFrames) {
  Scene scene = patterned();
  FrameMasks masks;
  for (int64_t i = 0; i < kTrained; ++i)
    masks.emplace_back(
        Image8{frame_of(scene, i).image.width, 4, 1,
               std::vector<uint8_t>(frame_of(scene, i).image.data.size() / 3, uint8_t(1 + i))});
  for (const int64_t budget : {int64_t{0}, int64_t{1}}) {  // all at once, a ring
    SeparateMemory memory;
    FrameCache feed(memory, scene, trained(), budget, 3, masks);
    EXPECT_EQ(feed.is_resident(), budget == 0);
    const TargetImages supplied = feed.truth({5, 0, 3});
    memory.inside([&] {
      EXPECT_EQ(std::vector<uint8_t>(supplied.masks[0].begin(), supplied.masks[0].end()),
                masks[5].data());
      EXPECT_EQ(std::vector<uint8_t>(supplied.masks[2].begin(), supplied.masks[2].end()),
                masks[3].data());
      EXPECT_EQ(std::vector<uint8_t>(supplied.images[2].begin(), supplied.images[2].end()),
                frame_of(scene, 3).image.data);
    });
  }
}

// Bugs put back, each seen to fail: a mask copied for each frame; the place of the first mask for
// all; one pinned for each frame.
TEST(FrameCache, FramesOfOneMaskShareItsCopy) {
  Scene scene = patterned();
  for (Frame& frame : scene.frames) frame.image = {5, 4, 3, std::vector<uint8_t>(60, 7)};
  const FrameMask first = Image8{5, 4, 1, std::vector<uint8_t>(20, 255)};
  const FrameMask second = Image8{5, 4, 1, std::vector<uint8_t>(20, 0)};
  for (int64_t i = 0; i < kTrained; ++i)
    scene.frames[size_t(trained()[size_t(i)])].mask = i < 5 ? first : second;
  for (const int64_t budget : {int64_t{0}, int64_t{1}}) {  // all at once, a ring
    SeparateMemory memory;
    FrameCache feed(memory, scene, trained(), budget, 4);
    const TargetImages supplied = feed.truth({3, 6, 4, 0});
    EXPECT_EQ(memory.async_copies, budget == 0 ? kTrained + 2 : 4 + 2);
    EXPECT_EQ(supplied.masks[2].data, supplied.masks[0].data);
    expect_frames(memory, scene, supplied, {3, 6, 4, 0});
    EXPECT_EQ(memory.pinned(), budget == 0 ? 0u : kTrained + 2u);
  }
}

// Bugs put back, each seen to fail: what the frame's mask ignores marked, too; all pixels marked;
// pixels of a camera that moves taken for still ones.
TEST(FrameCache, MovingPixelsAreMarked) {
  Scene scene;
  for (int t = 0; t < 5; ++t) {
    Frame frame;
    frame.camera_name = "still";
    frame.time = t / 4.0f;
    frame.image = {4, 2, 3, std::vector<uint8_t>(24, 100)};
    if (t == 3) frame.image.data[3 * 5 + 1] = 111;  // in one channel, by more than 10
    if (t == 3) frame.image.data[3 * 6 + 1] = 110;
    if (t == 4) frame.image.data[0] = 50;
    if (t == 4) frame.mask = Image8{4, 2, 1, {0, 0, 255, 255, 7, 255, 255, 255}};
    scene.frames.push_back(std::move(frame));
  }
  const FrameMasks masks = moving_masks(scene, {0, 3, 4});
  ASSERT_EQ(masks.size(), 3u);
  EXPECT_EQ(masks[0].data(), std::vector<uint8_t>(8, 1));
  EXPECT_EQ(masks[1].data(), (std::vector<uint8_t>{1, 1, 1, 1, 1, kMovingPixel, 1, 1}));
  EXPECT_EQ(masks[2].data(), (std::vector<uint8_t>{0, 0, 1, 1, 1, 1, 1, 1}));
  scene.frames[1].camera.translation.x = 1;
  EXPECT_TRUE(moving_masks(scene, {3})[0].data().empty()) << "the camera moves";
  scene.frames[3].mask = scene.frames[4].mask;
  const FrameMasks shared = moving_masks(scene, {3, 0, 4});
  EXPECT_EQ(shared[2].data(), (std::vector<uint8_t>{0, 0, 3, 3, 3, 3, 3, 3})) << "not known";
  EXPECT_EQ(shared[0].shared(), shared[2].shared());
  EXPECT_TRUE(shared[1].data().empty());
}

// Bugs put back, each seen to fail: a still image of another camera; the median of the window in
// place of the still image (who stands still all along counts as still); what the still image does
// not know counts as still.
TEST(MovingMasks, AreByTheStillImageOfALongerClip) {
  Scene scene;
  for (int t = 0; t < 4; ++t) {
    Frame frame;
    frame.camera_name = "cam";
    frame.time = t / 3.0;
    frame.image = {2, 2, 3, std::vector<uint8_t>(12, 100)};
    for (size_t c = 0; c < 3; ++c) frame.image.data[c] = 200;  // somebody, in every frame
    scene.frames.push_back(std::move(frame));
  }
  EXPECT_EQ(moving_masks(scene, {0})[0].data(), std::vector<uint8_t>(4, 1));
  Frame still = scene.frames[0];
  still.image.data.assign(12, 100);
  still.mask = Image8{2, 2, 1, {255, 255, 255, 0}};
  scene.stills = {still};
  EXPECT_EQ(moving_masks(scene, {0})[0].data(),
            (std::vector<uint8_t>{kMovingPixel, 1, 1, kMovingPixel}));
  scene.stills[0].camera.translation.x = 1;
  EXPECT_EQ(moving_masks(scene, {0})[0].data(), std::vector<uint8_t>(4, 1));
}

TEST(FrameCache, TheBudgetDecides) {
  const Scene scene = patterned();
  const auto ring = [&](int64_t free, int64_t budget) {
    SeparateMemory memory;
    memory.free = free;
    return FrameCache(memory, scene, trained(), budget, 1).ahead() > 0;
  };
  constexpr int64_t kPictures = 4 * 64 + 4 * 128, kAll = kPictures + kMasked * 64;  // aligned
  EXPECT_FALSE(ring(int64_t{1} << 40, 0));
  EXPECT_FALSE(ring(2 * kAll, 0)) << "half of a small card is for frames";
  EXPECT_TRUE(ring(kAll + 100, 0)) << "the other half is not";
  EXPECT_TRUE(ring(0, 0));
  EXPECT_FALSE(ring(0, kAll)) << "what was asked for is not second-guessed";
  EXPECT_TRUE(ring(0, kPictures)) << "masks are counted";
  EXPECT_TRUE(ring(int64_t{1} << 40, 100));
}

// Bug put back: the supply is made before it is used; seen to fail: a crash with a separate memory.
TEST(FrameCache, WithoutFramesIsRefused) {
  Scene scene = patterned();
  scene.path = "patterned";
  const auto refusal = [&](const auto& make) -> std::string {
    try {
      make();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  SeparateMemory memory;
  const std::string expected =
      "patterned: none of its 11 frames belongs to the training split; training needs at least one";
  EXPECT_EQ(refusal([&] { FrameCache(memory, scene, {}, 0, 1); }), expected);
  EXPECT_EQ(refusal([&] { FrameCache(host_memory(), scene, {}, 0, 1); }), expected);
  for (Frame& frame : scene.frames) frame.split = Split::kTest;
  SeparateBackend backend;
  EXPECT_EQ(refusal([&] { bench_stages(backend, scene, {}, {}); }), expected);
}

/// As the trainer drives it: truth, then the two batches to come.
// Bug put back: slots filled in turn, even while they are in use; seen to fail.
TEST(FrameCache, TheRingIsAlwaysAhead) {
  const Scene scene = patterned();
  for (int64_t batch : {1, 3, 5}) {
    SeparateMemory memory;
    memory.free = 0;
    FrameCache feed(memory, scene, trained(), 0, batch);
    ASSERT_EQ(feed.ahead(), 2);
    const int64_t buffers = memory.buffers();
    BatchSampler sampler(kTrained, 5);
    int64_t asked = 0;  // copies of the batches so far
    for (int step = 0; step < 30; ++step) {
      const std::vector<int64_t> indices = sampler.next(batch);
      const int64_t before = memory.async_copies;
      const TargetImages supplied = feed.truth(indices);
      asked += copies_of(scene, indices);
      EXPECT_EQ(memory.async_copies - before, step == 0 ? asked : 0) << "step " << step;
      feed.prefetch({sampler.peek(0, batch), sampler.peek(1, batch)});
      memory.wait_copies();  // even when all copies are done, this step's frames are still there
      expect_frames(memory, scene, supplied, indices);
      EXPECT_LE(memory.async_copies, asked + copies_of(scene, sampler.peek(0, batch)) +
                                         copies_of(scene, sampler.peek(1, batch)))
          << "nothing is brought over twice";
    }
    EXPECT_EQ(memory.buffers(), buffers);
    EXPECT_EQ(memory.copies, 0) << "none that waits";
  }
}

// Bug put back: no wait in truth; seen to fail.
TEST(FrameCache, TheRingSurvivesAJump) {
  const Scene scene = patterned();
  SeparateMemory memory;
  memory.free = 0;
  FrameCache feed(memory, scene, trained(), 0, 2);
  for (const std::vector<int64_t>& batch :
       {std::vector<int64_t>{0, 1}, {7, 6}, {0, 1}, {2, 2}, {5, 4}}) {
    expect_frames(memory, scene, feed.truth(batch), batch);
    feed.prefetch({{2, 2}, {2, 2}});
  }
}

// Bug put back: peek uses the batch up; seen to fail.
TEST(BatchSampler, PeekSeesWhatComes) {
  BatchSampler sampler(7, 3);
  for (int step = 0; step < 12; ++step) {
    const std::vector<int64_t> next = sampler.peek(0, 3), after = sampler.peek(1, 3);
    EXPECT_EQ(sampler.next(3), next);
    EXPECT_EQ(sampler.peek(0, 3), after);
  }
}

}  // namespace
}  // namespace tessera::testing
