// The figure: closed joints, a body that moves as a whole within the image, its truth and its seed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "ingest/files/ply.h"
#include "ingest/files/png.h"
#include "tests/support/scratch_folder.h"
#include "tests/tools/synth/figure_parts.h"
#include "tools/synth/render.h"
#include "tools/synth/rigs.h"

namespace tessera::synth {
namespace {

using glm::dvec3;
using tessera::testing::ScratchFolder;

/// A convex solid holds a point when rays along both directions of every axis leave it.
bool holds(const PlacedSolid& solid, const dvec3& point) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      Ray ray{point, {}};
      ray.direction[axis] = sign;
      Meeting meeting;
      cast(ray, solid, meeting);
      if (meeting.placed == nullptr) return false;
    }
  return true;
}

SynthOptions small_figure() {
  SynthOptions options;
  options.scene = SynthScene::kFigure;
  options.layout = SynthLayout::kDnerf;
  options.frames = 12;
  options.held_out_frames = 4;
  options.width = options.height = 96;
  options.supersampling = 2;
  return options;
}

// Seen to fail: the knee's pivot 0.01 above the end of the thigh; chains from the solid to the root
// in the wrong order.
TEST(SynthFigure, KneesAndElbowsStayClosed) {
  const World world = build_world(SynthScene::kFigure, 1, 0);
  const std::array<std::array<std::string, 2>, 4> links{{{"left thigh", "left shin"},
                                                         {"right thigh", "right shin"},
                                                         {"left upper arm", "left forearm"},
                                                         {"right upper arm", "right forearm"}}};
  for (const auto& [upper_name, lower_name] : links) {
    const Solid &upper = part(world, upper_name), &lower = part(world, lower_name);
    double least = 180, most = 0;
    for (const double time : many_times()) {
      EXPECT_LT(glm::distance(end_of(upper, -1, time), end_of(lower, 1, time)), 1e-6)
          << lower_name << " at " << time;
      const dvec3 along_upper = end_of(upper, -1, time) - end_of(upper, 1, time);
      const dvec3 along_lower = end_of(lower, -1, time) - end_of(lower, 1, time);
      const double bend = glm::degrees(
          std::acos(glm::dot(glm::normalize(along_upper), glm::normalize(along_lower))));
      least = std::min(least, bend);
      most = std::max(most, bend);
    }
    EXPECT_LT(least, 20) << lower_name;
    EXPECT_GT(most, 80) << lower_name;
    EXPECT_LE(most, 95) << lower_name;
    EXPECT_NEAR(lower.shape.half.y / upper.shape.half.x, 1, 0.05) << "balls of one size";
  }
}

// The balls of hips, shoulders, neck, ankles and wrists have their middles inside what they join.
// Seen to fail: shoulders 0.06 further out.
TEST(SynthFigure, LimbsStayInTheTrunkAndHandsOnTheArms) {
  const World world = build_world(SynthScene::kFigure, 1, 0);
  struct Joined {
    std::string outer, inner;
    int end;  // of the inner part
  };
  std::vector<Joined> joined{{"chest", "neck", -1}, {"head", "neck", 1}, {"pelvis", "chest", -1}};
  for (const std::string side : {"left ", "right "}) {
    joined.push_back({"pelvis", side + "thigh", 1});
    joined.push_back({"chest", side + "upper arm", 1});
    joined.push_back({side + "foot", side + "shin", -1});
    joined.push_back({side + "hand", side + "forearm", -1});
  }
  for (const double time : many_times()) {
    const std::vector<PlacedSolid> placed = place(world, Part::kMoving, time);
    for (const Joined& pair : joined) {
      const auto outer = std::find_if(
          placed.begin(), placed.end(),
          [&](const PlacedSolid& candidate) { return candidate.solid->name == pair.outer; });
      ASSERT_NE(outer, placed.end()) << pair.outer;
      EXPECT_TRUE(holds(*outer, end_of(part(world, pair.inner), pair.end, time)))
          << pair.inner << " in " << pair.outer << " at " << time;
    }
  }
}

// A step of a 150 frame clip moves nothing far, and two steps in a row nearly alike.
// Seen to fail: the head without joints; angles by the absolute value of a sine.
TEST(SynthFigure, MovesSmoothlyAndEverythingMoves) {
  const World world = build_world(SynthScene::kFigure, 1, 0);
  constexpr double kStep = 1.0 / 149;
  for (const Solid& solid : world.solids) {
    EXPECT_TRUE(solid.moves) << solid.name;
    double farthest = 0;
    for (const double time : many_times()) {
      const dvec3 before = end_of(solid, -1, time - kStep), now = end_of(solid, -1, time);
      const dvec3 after = end_of(solid, -1, time + kStep);
      farthest = std::max(farthest, glm::distance(before, now));
      EXPECT_LT(glm::length(after - 2.0 * now + before), 0.012) << solid.name << " at " << time;
    }
    EXPECT_LT(farthest, 0.1) << solid.name;
    EXPECT_GT(farthest, 0.001) << solid.name;
  }
}

struct Silhouette {
  int left = 1 << 20, right = -1, top = 1 << 20, bottom = -1;
  std::vector<uint8_t> covered;

  explicit Silhouette(const RenderedImage& image) : covered(image.mask.size()) {
    for (int p = 0; p < image.width * image.height; ++p) {
      covered[size_t(p)] = image.rgba[size_t(4 * p + 3)] > 0;
      if (covered[size_t(p)] == 0) continue;
      left = std::min(left, p % image.width);
      right = std::max(right, p % image.width);
      top = std::min(top, p / image.width);
      bottom = std::max(bottom, p / image.width);
    }
  }
};

// Seen to fail: cameras as high as those of the toy; cameras at 2.8; a belt that is static.
TEST(SynthFigure, FillsTheImageAndStaysWithinIt) {
  const SynthOptions options = small_figure();
  const World world = build_world(options.scene, options.seed, 0);
  for (const PoseSet set : {PoseSet::kTrain, PoseSet::kTest}) {
    const std::vector<Camera> cameras = monocular_poses(options, world.target, set, 60);
    for (int i = 0; i < 60; ++i) {
      const RenderedImage image = render(world, cameras[size_t(i)], i / 59.0, 1);
      const Silhouette seen(image);
      EXPECT_GT(seen.left, 2) << i;
      EXPECT_LT(seen.right, 93) << i;
      EXPECT_GT(seen.top, 2) << i;
      EXPECT_LT(seen.bottom, 93) << i;
      EXPECT_GT(seen.bottom - seen.top, 0.55 * 96) << i;
      for (size_t p = 0; p < image.mask.size(); ++p)
        ASSERT_EQ(image.mask[p] != 0, seen.covered[p] != 0) << "all of the figure moves";
    }
  }
}

// Seen to fail: joints as at the first timestep.
TEST(SynthFigure, SilhouetteDiffersBetweenTimes) {
  const SynthOptions options = small_figure();
  const World world = build_world(options.scene, options.seed, 0);
  const Camera camera =
      look_at({2.8, -2.8, 0.6}, world.target, 96, 96, field_of_view(options.scene));
  const Silhouette start(render(world, camera, 0, 1));
  for (const double time : {0.1, 0.25, 0.4, 0.6, 0.75, 0.9}) {
    const Silhouette now(render(world, camera, time, 1));
    int64_t differing = 0, both = 0;
    for (size_t p = 0; p < now.covered.size(); ++p) {
      differing += now.covered[p] != start.covered[p];
      both += now.covered[p] != 0 && start.covered[p] != 0;
    }
    EXPECT_GT(double(differing), 0.1 * double(both)) << time;
    EXPECT_GT(both, 300) << time;
  }
}

// Seen to fail: the world's seed ignored; a belt that is static.
TEST(SynthFigure, CaptureHasItsTruthAndFollowsFromTheSeed) {
  const ScratchFolder folder;
  SynthOptions options = small_figure();
  options.frames = 4;
  const SynthReport report = make_capture(options, folder / "a", {});
  EXPECT_EQ(report.images, 12);
  EXPECT_EQ(report.points, 0) << "nothing of it is static";
  const PlyFile points = read_ply(folder / "a/ground_truth/points.ply");
  ASSERT_NE(points.find("vertex"), nullptr);
  EXPECT_EQ(points.find("vertex")->rows, 0);
  make_capture(options, folder / "b", {});
  for (const char* name : {"r_000.png", "r_003.png"}) {
    const Image8 image = read_png(folder / "a/train" / name);
    EXPECT_EQ(image.data, read_png(folder / "b/train" / name).data);
    EXPECT_EQ(image.data[3], 0) << "the corner is empty";
    const Image8 mask =
        read_png(folder / "a/ground_truth" / (std::string("mask_train_") + (name + 2)));
    for (size_t p = 0; p < mask.data.size(); ++p)
      ASSERT_EQ(mask.data[p] != 0, image.data[4 * p + 3] != 0) << name << " pixel " << p;
  }
  const Camera camera = look_at({2.8, -2.8, 0.6}, dvec3(0), 96, 96, field_of_view(options.scene));
  const auto pixels = [&](uint64_t seed) {
    return render(build_world(SynthScene::kFigure, seed, 0), camera, 0.3, 1).rgba;
  };
  EXPECT_EQ(pixels(1), pixels(1));
  EXPECT_NE(pixels(1), pixels(2));
}

}  // namespace
}  // namespace tessera::synth
