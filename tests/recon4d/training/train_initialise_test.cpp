// The initial Gaussians: scales from neighbours, attributes, shares of the sets, carving, and small
// clouds. Source: method A.2, D.4.
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/load_gaussian.h"
#include "recon4d/training/initialise.h"
#include "tests/recon4d/model/neighbour_distance.h"
#include "tests/support/random.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {
namespace {

/// A scene whose cloud has `count` points in a ball of radius 0.7, coloured.
Scene scene_with_cloud(int count) {
  Scene scene = tiny_capture({.cameras = 3, .timesteps = 2, .size = 8});
  Random random(9);
  for (int i = 0; i < count; ++i) {
    scene.points.position.push_back(
        {random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4)});
    scene.points.colour.push_back({uint8_t(i % 256), uint8_t(255 - i % 256), 51});
  }
  return scene;
}

Initialisation initialise(const Scene& scene, const TrainOptions& options) {
  return initialise_model(scene, make_camera_rig(scene.training_cameras()), options);
}

void expect_attributes(const Scene& scene, const GaussianSet& set, const TrainOptions& options) {
  const std::vector<float> squared = brute_force_distance(scene.points.position);
  const GaussianSpans<const float> v = set.values();
  for (int64_t n = 0; n < set.count(); ++n) {
    const float* mean = v.at(kMean, n);
    size_t i = 0;  // the point it came from
    while (scene.points.position[i] != glm::vec3(mean[0], mean[1], mean[2])) ++i;
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(v.at(kLogScale, n)[k], 0.5 * std::log(squared[i]), 1e-5);
      const double colour = 0.5 + 0.28209479177387814 * v.at(kSh, n)[k];
      EXPECT_NEAR(255 * colour, scene.points.colour[i][size_t(k)], 1e-4);
    }
    for (int k = 3; k < set.width(kSh); ++k) EXPECT_EQ(v.at(kSh, n)[k], 0);
    EXPECT_NEAR(*v.at(kOpacityLogit, n), -2.19722, 1e-5);
    for (Group side : {kRotation, kRotationRight}) {
      if (side == kRotationRight && set.dim() == 3) continue;
      for (int k = 0; k < 4; ++k) EXPECT_EQ(v.at(side, n)[k], k == 0 ? 1 : 0);
    }
    if (set.dim() == 3) continue;
    EXPECT_NEAR(*v.at(kLogScaleTime, n), std::log(options.init_time_scale), 1e-6);
  }
}

TEST(Initialise, AttributesOfACloud) {
  const Scene scene = scene_with_cloud(200);
  TrainOptions options;
  options.static_fraction = 0.3;
  const Initialisation made = initialise(scene, options);
  EXPECT_EQ(made.model.static_set.count(), 60);
  EXPECT_EQ(made.model.dynamic_set.count(), 140);
  EXPECT_EQ(made.model.static_set.coefficients(), 16);
  expect_attributes(scene, made.model.static_set, options);
  expect_attributes(scene, made.model.dynamic_set, options);
  EXPECT_NEAR(options.init_time_scale * options.init_time_scale, 0.2, 1e-9);
  EXPECT_EQ(made.model.drawing.sh_degree, 0);
  EXPECT_EQ(made.model.background, scene.background);
  EXPECT_NE(made.source.find("200"), std::string::npos) << made.source;
}

TEST(Initialise, TemporalMeansFillTheClipAndATenthBeyond) {
  TrainOptions options;
  options.init_points = 20000;
  options.init_extent = 0.5;
  const Scene scene = scene_with_cloud(0);
  const GaussianModel model = initialise(scene, options).model;
  double low = 9, high = -9, sum = 0;
  for (float t : model.dynamic_set.group(kMeanTime).value) {
    low = std::min<double>(low, t);
    high = std::max<double>(high, t);
    sum += t;
  }
  const double count = double(model.dynamic_set.count());
  EXPECT_GE(low, -0.1 - 1e-6);
  EXPECT_LT(high, 1.1 + 1e-6);
  EXPECT_NEAR(low, -0.1, 0.002);
  EXPECT_NEAR(high, 1.1, 0.002);
  EXPECT_NEAR(sum / count, 0.5, 5 * 1.2 / std::sqrt(12 * count));
}

// Bug put back: the share owed is not carried from one point to the next; seen to fail.
TEST(Initialise, SharesAreExactAndSpreadOut) {
  const Scene scene = scene_with_cloud(101);
  for (double share : {0.0, 0.01, 0.25, 0.5, 0.77, 1.0}) {
    TrainOptions options;
    options.static_fraction = share;
    const GaussianModel model = initialise(scene, options).model;
    EXPECT_EQ(model.static_set.count(), int64_t(101 * share + 1e-6));
    EXPECT_EQ(model.count(), 101);
  }
  TrainOptions half;
  half.static_fraction = 0.5;
  const GaussianModel model = initialise(scene, half).model;
  // neighbours in the cloud's order alternate: both sets cover the whole cloud
  EXPECT_EQ(model.dynamic_set.group(kMean).value[0], scene.points.position[0].x);
  EXPECT_EQ(model.static_set.group(kMean).value[3 * 49], scene.points.position[99].x);
  half.motion = Motion::kNone;
  EXPECT_EQ(initialise(scene, half).model.dynamic_set.count(), 0);
}

TEST(Initialise, LargeCloudsAreThinnedWithoutRepetition) {
  const Scene scene = scene_with_cloud(500);
  TrainOptions options;
  options.motion = Motion::kNone;
  options.init_points = 77;
  const GaussianModel model = initialise(scene, options).model;
  ASSERT_EQ(model.count(), 77);
  const GaussianSpans<const float> v = model.static_set.values();
  for (int64_t a = 0; a < 77; ++a)
    for (int64_t b = 0; b < a; ++b) EXPECT_NE(v.at(kMean, a)[0], v.at(kMean, b)[0]);
  EXPECT_EQ(v.at(kMean, 0)[0], scene.points.position[0].x);
  EXPECT_GE(v.at(kMean, 76)[0], -0.4f);
}

// Bugs put back: the time of a point not used; unknown `still` taken as moving; seen to fail.
TEST(Initialise, TimesAndStaticPointsOfACloudAreTaken) {
  Scene scene = scene_with_cloud(30);
  for (int i = 0; i < 30; ++i) {
    scene.points.time.push_back(i % 3 == 2 ? NAN : float(i) / 30);
    scene.points.still.push_back(i % 3 == 2 ? PointCloud::kStillUnknown : uint8_t(i % 3));
  }
  TrainOptions options;
  options.split_by_motion = true;
  options.static_fraction = 1;
  options.init_points = 30;
  options.carve = false;
  const Initialisation made = initialise(scene, options);
  EXPECT_NE(made.source.find("3 at random"), std::string::npos) << made.source;
  // dynamic: the ten that move. Static: ten still ones, ten without a velocity, by the share
  ASSERT_EQ(made.model.dynamic_set.count(), 10);
  ASSERT_EQ(made.model.static_set.count(), 20 + 3);
  for (int64_t n = 0; n < 10; ++n) {
    EXPECT_EQ(made.model.dynamic_set.group(kMeanTime).value[n], float(3 * n) / 30);
    EXPECT_EQ(made.model.dynamic_set.group(kMean).value[3 * n],
              scene.points.position[size_t(3 * n)].x);
  }
  options.split_by_motion = false;
  options.static_fraction = 0;
  const GaussianModel dynamic = initialise(scene, options).model;
  ASSERT_EQ(dynamic.dynamic_set.count(), 33);
  EXPECT_EQ(dynamic.dynamic_set.group(kMeanTime).value[4], float(4) / 30);
}

// Bug put back: velocities left at 0; seen to fail.
TEST(Initialise, VelocitiesOfACloudAreTaken) {
  Scene scene = scene_with_cloud(30);
  for (int i = 0; i < 30; ++i) {
    scene.points.time.push_back(float(i) / 30);
    scene.points.still.push_back(uint8_t(i % 3 == 1));
    scene.points.velocity.emplace_back(i, -i, 0.5f);
  }
  TrainOptions options;
  options.split_by_motion = true;
  options.init_points = 30;
  options.motion = Motion::kVelocity;
  const GaussianModel moving = initialise(scene, options).model;
  const GaussianSpans<const float> v = moving.dynamic_set.values();
  int taken = 0;
  for (int i = 0; i < 30; ++i) {
    if (i % 3 == 1) continue;
    EXPECT_EQ(v.at(kVelocity, taken)[0], float(i));
    EXPECT_EQ(v.at(kVelocity, taken)[1], float(-i));
    EXPECT_EQ(v.at(kVelocity, taken++)[2], 0.5f);
  }
  for (int64_t n = taken; n < moving.dynamic_set.count(); ++n)
    EXPECT_EQ(v.at(kVelocity, n)[2], 0) << "random points have none";
  // Bug put back: pairs that start at rest; seen to fail.
  options.motion = Motion::kPair;
  const GaussianModel pairs = initialise(scene, options).model;
  const GaussianSpans<const float> p = pairs.dynamic_set.values();
  for (int64_t n = 0; n < taken; ++n) {
    const Spacetime<double> s = pair_spacetime(
        Vec4<double>(load4(p.at(kRotation, n))), Vec4<double>(load4(p.at(kRotationRight, n))),
        Vec3<double>(load3(p.at(kLogScale, n))), double(*p.at(kLogScaleTime, n)), 0.0);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(s.velocity[k], v.at(kVelocity, n)[k], 1e-3 * (1 + std::abs(s.velocity[k]))) << n;
    EXPECT_NEAR(1 / std::sqrt(s.precision_time), options.init_time_scale, 1e-4);
  }
  scene.points.velocity.clear();
  const GaussianModel resting = initialise(scene, options).model;
  EXPECT_EQ(resting.dynamic_set.values().at(kRotationRight, 0)[0], 1) << "at rest";
  EXPECT_EQ(resting.dynamic_set.values().at(kRotation, 0)[0], 1);
}

// Bug put back: max_gaussians is ignored before the first step; seen to fail.
TEST(Initialise, NeverMoreThanTheLimit) {
  TrainOptions options;
  options.init_points = 300;
  options.max_gaussians = 120;
  options.init_extent = 0.3;
  EXPECT_EQ(initialise(scene_with_cloud(200), options).model.count(), 120);
  EXPECT_EQ(initialise(scene_with_cloud(0), options).model.count(), 120);
}

// Bug put back: `carve` ignored; seen to fail.
TEST(Initialise, CarvedPointsAreInAView) {
  const Scene scene = scene_with_cloud(0);
  const CameraRig rig = make_camera_rig(scene.training_cameras());
  TrainOptions options;
  options.init_points = 4000;
  options.init_extent = 6;
  options.motion = Motion::kNone;
  const auto unseen = [&](const GaussianModel& model) {
    int64_t count = 0;
    const GaussianSpans<const float> v = model.static_set.values();
    for (int64_t n = 0; n < model.count(); ++n) {
      const float* p = v.at(kMean, n);
      bool seen = false;
      for (const Camera& camera : rig.cameras) {
        const glm::dvec3 c =
            camera.cam_from_world * glm::dvec3(p[0], p[1], p[2]) + camera.translation;
        const double x = camera.fl_x * c.x / c.z + camera.cx;
        const double y = camera.fl_y * c.y / c.z + camera.cy;
        const double band = 1e-3;  // pixels; means are stored in float
        seen = seen || (c.z >= options.near_plane - band && x >= -band && y >= -band &&
                        x <= camera.width + band && y <= camera.height + band);
      }
      count += !seen;
    }
    return count;
  };
  const GaussianModel carved = initialise(scene, options).model;
  EXPECT_EQ(unseen(carved), 0);
  EXPECT_GT(carved.count(), 100);
  EXPECT_LT(carved.count(), 4000);
  options.carve = false;
  const GaussianModel whole = initialise(scene, options).model;
  EXPECT_EQ(whole.count(), 4000);
  EXPECT_EQ(unseen(whole), 4000 - carved.count());
}

TEST(Initialise, RandomPointsSurroundTheFocusOrFillTheViews) {
  Scene scene = scene_with_cloud(0);
  const CameraRig rig = make_camera_rig(scene.training_cameras());
  TrainOptions options;
  options.init_points = 3000;
  options.motion = Motion::kNone;
  scene.had_alpha = false;  // a room: points in view, near to far
  const GaussianModel room = initialise(scene, options).model;
  EXPECT_EQ(room.count(), 3000) << "each is drawn in a view";
  float farthest = 0;
  for (float x : room.static_set.group(kMean).value) farthest = std::max(farthest, std::abs(x));
  EXPECT_GT(farthest, 1.5 * rig.distance);
  options.init_extent = 0.25;  // a box
  const GaussianModel boxed = initialise(scene, options).model;
  const GaussianSpans<const float> v = boxed.static_set.values();
  for (int64_t n = 0; n < boxed.count(); ++n)
    for (int k = 0; k < 3; ++k) EXPECT_LE(std::abs(v.at(kMean, n)[k] - rig.focus[k]), 0.25 + 1e-6);
}

TEST(Initialise, AllCarvedAwayGivesTheRemedy) {
  Scene scene = scene_with_cloud(0);
  TrainOptions options;
  options.near_plane = 90;  // nothing of the box is that far away
  options.init_extent = 1;
  try {
    initialise(scene, options);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("--init-extent"), std::string::npos) << error.what();
  }
}

TEST(Initialise, OnePointAndNone) {
  TrainOptions options;
  options.motion = Motion::kNone;
  const GaussianModel one = initialise(scene_with_cloud(1), options).model;
  ASSERT_EQ(one.count(), 1);
  EXPECT_NEAR(one.static_set.group(kLogScale).value[0], 0.5 * std::log(1e-7), 1e-5);
  options.init_points = 0;
  EXPECT_EQ(initialise(scene_with_cloud(0), options).model.count(), 0);
  EXPECT_EQ(initialise(scene_with_cloud(5), options).model.count(), 0);
}

// Bugs put back, each seen to fail: still points beyond the shared set for a few frames alone;
// still points that it shows placed again. Finds also: others static; a shared set that is changed.
TEST(Initialise, BesideASharedStaticSetAllIsDynamic) {
  Scene scene = scene_with_cloud(40);
  scene.points.still.assign(40, 0);
  scene.points.time.assign(40, 0.25F);
  for (size_t i = 0; i < 20; ++i) scene.points.still[i] = 1;
  const glm::vec3 away(5, 0, 0);
  for (size_t i = 10; i < 20; ++i) scene.points.position[i] += away;  // what the set has not
  TrainOptions options;
  options.split_by_motion = true;
  options.init_time_scale = 0.05;
  const Initialisation alone = initialise(scene, options);
  GaussianSet shared(SetForm::kStatic, sh_coefficients(int(options.sh_degree)));
  shared.resize(10);
  for (int64_t n = 0; n < 10; ++n)
    for (int k = 0; k < 3; ++k)
      shared.values().at(kMean, n)[k] = scene.points.position[size_t(n)][k] + 0.001F;
  const GaussianModel model =
      initialise_model(scene, make_camera_rig(scene.training_cameras()), options, &shared).model;
  ASSERT_EQ(model.static_set.count(), 10);
  EXPECT_EQ(model.static_set.values().at(kMean, 3)[0], shared.values().at(kMean, 3)[0]);
  int64_t lasting = 0, brief = 0;
  const GaussianSpans<const float> moving = std::as_const(model.dynamic_set).values();
  for (int64_t n = 0; n < moving.count; ++n) {
    const float scale = std::exp(*moving.at(kLogScaleTime, n));
    (scale > 0.9F ? lasting : brief) += 1;
    if (scale > 0.9F) {
      EXPECT_NEAR(scale, 1, 1e-5);
      EXPECT_GT(moving.at(kMean, n)[0], 4);
    }
  }
  EXPECT_EQ(lasting, 10);
  EXPECT_GE(brief, 20) << "and those at random";
  EXPECT_LT(alone.model.dynamic_set.count(), moving.count);
}

}  // namespace
}  // namespace tessera::testing
