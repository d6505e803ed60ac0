// Models moved to another world render as before from moved cameras, SH is rotated exactly, and
// files keep the world. The choice of the world is tested in
// tests/ingest/poses/world_normalisation_test.cpp.
#include <nlohmann/json.hpp>

#include "kernels/math/environment.h"
#include "kernels/math/four_rotation.h"
#include "kernels/math/rotation3.h"
#include "kernels/math/spacetime.h"
#include "recon4d/model/checkpoint.h"
#include "recon4d/model/model_file.h"
#include "static3d/transform/sh_rotation.h"
#include "static3d/transform/slicer.h"
#include "static3d/transform/world_change.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/recon4d/model/small_models.h"
#include "tests/support/lift.h"

namespace tessera::testing {
namespace {

Vec4<double> random_quaternion(Random& random) {
  const auto q = random.array<4>(-1, 1);
  return normalised(Vec4<double>(q[0], q[1], q[2], q[3]));
}

Similarity random_similarity(uint64_t seed, double scale) {
  Random random(seed);
  Similarity s;
  s.scale = scale;
  s.rotation = rotation_matrix(random_quaternion(random));
  s.translation = {random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)};
  return s;
}

View view_in_world(const Similarity& world, const View& view) {
  return {camera_in_world(world, view.camera), view.time};
}

double largest_difference(const RenderedImage& a, const RenderedImage& b) {
  double largest = 0;
  for (size_t i = 0; i < a.rgb.size(); ++i)
    largest = std::max(largest, std::abs(double(a.rgb[i]) - double(b.rgb[i])));
  return largest;
}

TEST(Similarity, InverseAndCompositionAreThoseOfTheMaps) {
  const Similarity a = random_similarity(1, 2.5), b = random_similarity(2, 0.3);
  const glm::dvec3 x(0.3, -1.2, 4);
  EXPECT_LT(glm::distance(compose(b, a)(x), b(a(x))), 1e-13);
  EXPECT_LT(glm::distance(inverse(a)(a(x)), x), 1e-14);
  EXPECT_EQ(similarity_from_numbers(similarity_numbers(a)), a);
  // A moved camera sees the moved point at the same pixel, at `scale` times the depth.
  const Camera camera = three_views()[1].camera, moved = camera_in_world(a, camera);
  const glm::dvec3 p(0.1, 0.2, -0.3);
  const glm::dvec3 before = camera.cam_from_world * p + camera.translation;
  const glm::dvec3 after = moved.cam_from_world * a(p) + moved.translation;
  EXPECT_LT(glm::distance(after, 2.5 * before), 1e-13);
}

// Bug put back: the transposed rotation; seen to fail.
TEST(ShRotation, IsTheColourAlongTurnedDirections) {
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const Mat3<double> R = rotation_matrix(random_quaternion(random));
    double sh[48], turned[48];
    for (int k = 0; k < 48; ++k) turned[k] = sh[k] = random.uniform(-1, 1);
    ShRotation(R).apply(16, turned);
    for (int trial = 0; trial < 20; ++trial) {
      const Vec3<double> d = glm::normalize(
          Vec3<double>(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)));
      const Vec3<double> one = sh_colour(3, d, sh), other = sh_colour(3, R * d, turned);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(one[c], other[c], 1e-12);
    }
  }
}

TEST(ShRotation, ComposesAndLeavesOtherBandsAlone) {
  Random random(5);
  const Mat3<double> A = rotation_matrix(random_quaternion(random));
  const Mat3<double> B = rotation_matrix(random_quaternion(random));
  double sh[48], twice[48], once[48], few[12];
  for (int k = 0; k < 48; ++k) once[k] = twice[k] = sh[k] = random.uniform(-1, 1);
  std::copy_n(sh, 12, few);
  ShRotation(A).apply(16, twice);
  ShRotation(B).apply(16, twice);
  ShRotation(B * A).apply(16, once);
  ShRotation(B * A).apply(4, few);
  for (int k = 0; k < 48; ++k) EXPECT_NEAR(once[k], twice[k], 1e-12) << k;
  for (int k = 0; k < 12; ++k) EXPECT_EQ(few[k], once[k]) << k;
}

TEST(FourRotation, QuaternionsAreFoundFromTheMatrix) {
  Random random(6);
  for (int i = 0; i < 100; ++i) {
    const Mat4<double> R = rotation4(random_quaternion(random), random_quaternion(random));
    Vec4<double> l, r;
    quaternions_of_rotation4(R, l, r);
    const Mat4<double> again = rotation4(l, r);
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) EXPECT_NEAR(again.m[a][b], R.m[a][b], 1e-14);
  }
}

// The closed form: b/w and Σ_c of the conditional scale with space, w does not.
TEST(FourRotation, AScaleOfSpaceScalesVelocityAndCovariance) {
  Random random(7);
  for (double s : {0.05, 0.7, 3.0, 40.0})
    for (int i = 0; i < 50; ++i) {
      const auto logs = random.array<4>(-3, 1);
      Shape4 shape{random_quaternion(random), random_quaternion(random), {}};
      for (int k = 0; k < 4; ++k) shape.sigma[k] = std::exp(logs[size_t(k)]);
      const auto spacetime = [](const Shape4& g) {
        return pair_spacetime(
            g.left, g.right,
            Vec3<double>(std::log(g.sigma[1]), std::log(g.sigma[2]), std::log(g.sigma[3])),
            std::log(g.sigma[0]), 0.5);
      };
      const Spacetime<double> before = spacetime(shape);
      ASSERT_TRUE(scale_space(s, shape));
      const Spacetime<double> after = spacetime(shape);
      EXPECT_NEAR(after.precision_time, before.precision_time, 1e-11 * before.precision_time);
      const double speed = glm::length(before.velocity), size = before.covariance.xx;
      EXPECT_LT(glm::length(after.velocity - s * before.velocity), 1e-11 * s * (speed + 1));
      EXPECT_NEAR(after.covariance.xx, s * s * size, 1e-11 * s * s * (size + 1));
      EXPECT_NEAR(after.covariance.xy, s * s * before.covariance.xy, 1e-11 * s * s * (size + 1));
    }
}

// Law of similarities. Bugs put back, each seen to fail: SH not turned; ln s not added to the log
// scales; only the left quaternion turned; clip planes not scaled.
TEST(WorldChange, ImagesStayFromMovedCameras) {
  GaussianModel model = random_model(40, 60);
  model.drawing.near_plane = 3.2;  // through the middle of the Gaussians: it must move along
  for (const auto& [seed, scale] : {std::pair{11, 1.0}, {12, 0.21}, {13, 7.5}}) {
    const Similarity world = random_similarity(uint64_t(seed), scale);
    const GaussianModel moved = model_in_world(world, model);
    EXPECT_EQ(moved.prepared_from_source, world);
    for (const View& view : three_views()) {
      const RenderedImage expected = render_one(model, view);
      EXPECT_GT(coverage(expected), 0.05);
      // Single rounding of parameters of size 1 to 30: 30 · 6e-8 of an image's width or height.
      expect_same_image(render_one(moved, view_in_world(world, view)), expected, 2e-5);
    }
  }
}

// The static part alone, with degree 3 and clear anisotropy, is exact to single rounding.
TEST(WorldChange, StaticImagesStayTo1e5) {
  const GaussianModel model = random_model(60, 0);
  Similarity world = random_similarity(21, 1.6);
  world.translation *= 0.1;
  for (const View& view : three_views())
    EXPECT_LT(
        largest_difference(render_one(model_in_world(world, model), view_in_world(world, view)),
                           render_one(model, view)),
        1e-5);
}

TEST(WorldChange, ThereAndBackAndTheIdentity) {
  const GaussianModel model = random_model(20, 30);
  EXPECT_TRUE(same_bits(model_in_world({}, model).static_set, model.static_set));
  EXPECT_TRUE(same_bits(model_in_world({}, model).dynamic_set, model.dynamic_set));
  const Similarity world = random_similarity(31, 3.3);
  const GaussianModel back = model_in_source_world(model_in_world(world, model));
  EXPECT_TRUE(back.prepared_from_source.is_identity());
  EXPECT_NEAR(back.drawing.near_plane, model.drawing.near_plane, 1e-12);
  for (const View& view : three_views())
    expect_same_image(render_one(back, view), render_one(model, view), 1e-5);
  for (Group same : {kMeanTime, kOpacityLogit})
    for (int64_t n = 0; n < 30; ++n)
      EXPECT_EQ(back.dynamic_set.group(same).value[n], model.dynamic_set.group(same).value[n]);
}

// Bug put back: the whole way back to map coordinates; seen to fail (places are lost).
TEST(WorldChange, MapCoordinatesAreLeftOutOnTheWayBack) {
  GaussianModel model = random_model(20, 30);
  model.prepared_from_source.translation = {-399876.5, -5711234.25, -143.5};
  const GaussianModel back = model_in_source_world(model);
  const glm::dvec3 origin = -back.prepared_from_source.translation;
  EXPECT_EQ(origin, glm::dvec3(399877, 5711234, 144));
  const auto& means = back.static_set.group(kMean).value;
  for (int64_t i = 0; i < 60; ++i)
    EXPECT_NEAR(means[i] + origin[i % 3],
                model.static_set.group(kMean).value[i] -
                    model.prepared_from_source.translation[glm::length_t(i % 3)],
                1e-5);
}

// A slice of the moved model is the moved slice. Bugs put back, each seen to fail: only l turned;
// ln s added to the log scales of moving Gaussians, whose axes mix space and time.
TEST(WorldChange, CommutesWithSlicing) {
  const GaussianModel model = random_model(0, 50);
  const Similarity world = random_similarity(41, 2.2);
  const GaussianSet one = slice_model(model_in_world(world, model), 0.4);
  const GaussianSet before = slice_model(model, 0.4);
  ASSERT_EQ(one.count(), before.count());
  for (int64_t n = 0; n < one.count(); ++n) {
    const float* const p = before.values().at(kMean, n);
    const glm::dvec3 expected = world({double(p[0]), double(p[1]), double(p[2])});
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(one.values().at(kMean, n)[k], expected[k], 5e-6);  // |x| ≤ 8 in single
  }
}

TEST(WorldChange, ALiftedStaticGaussianStaysOne) {
  GaussianModel model = random_model(10, 0);
  model.dynamic_set = lift_to_4d(model.static_set, 8.0f);
  const GaussianModel moved = model_in_world(random_similarity(51, 5), model);
  for (int64_t n = 0; n < 10; ++n) {
    EXPECT_EQ(*moved.dynamic_set.values().at(kLogScaleTime, n), 8.0f);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(moved.dynamic_set.values().at(kMean, n)[k],
                moved.static_set.values().at(kMean, n)[k]);
      EXPECT_EQ(moved.dynamic_set.values().at(kLogScale, n)[k],
                moved.static_set.values().at(kLogScale, n)[k]);
    }
  }
}

// Bug put back: the map not turned; seen to fail.
TEST(WorldChange, EnvironmentIsSeenAsBefore) {
  GaussianModel model = random_model(3, 2);
  model.environment.height = 4;
  model.environment.map.value.resize(environment_scalars(4));
  Random random(71);
  for (float& value : model.environment.map.value) value = float(random.uniform(0, 1));
  const Similarity world = random_similarity(72, 1.7);
  const GaussianModel moved = model_in_world(world, model);
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  for (const View& view : three_views()) {
    const RenderedImage before = render_views(*backend, model, {view}).front();
    const RenderedImage after = render_views(*backend, moved, {view_in_world(world, view)}).front();
    EXPECT_LT(largest_difference(before, after), 1e-4);
  }
}

// Bug put back: the comment not written; seen to fail.
TEST(WorldChange, ModelFilesCarryTheWorldBitForBit) {
  const TemporaryFolder folder;
  GaussianModel model = random_model(3, 2);
  model.prepared_from_source = random_similarity(61, 0.37);
  save_model(folder / "model.ply", model);
  EXPECT_EQ(load_model(folder / "model.ply").prepared_from_source, model.prepared_from_source);
  EXPECT_EQ(model.clone_values().prepared_from_source, model.prepared_from_source);
}

}  // namespace
}  // namespace tessera::testing
