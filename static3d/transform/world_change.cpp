// The parameter groups of a set under a similarity, Gaussian by Gaussian in double, and exact flips
// of the signs of axes.
#include "static3d/transform/world_change.h"

#include <array>
#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/base/far_origin.h"
#include "kernels/base/parallel.h"
#include "kernels/load_gaussian.h"
#include "kernels/math/carry.h"
#include "kernels/math/eigen3.h"
#include "kernels/math/four_rotation.h"
#include "static3d/transform/sh_rotation.h"

namespace tessera {
namespace {

/// Of the coefficients 0 to 15: each is odd in the axes of its polynomial.
std::array<float, kMaxShCoefficients> sh_signs(const AxisSigns& s) {
  const float xy = s.x * s.y, yz = s.y * s.z, xz = s.x * s.z;
  return {1, s.y, s.z, s.x, xy, yz, 1, xz, 1, s.y, xy * s.z, s.y, s.z, s.x, s.z, s.x};
}

constexpr int64_t kGrain = 4096;

void store4(const Vec4<double>& from, float* to) {
  for (int k = 0; k < 4; ++k) to[k] = float(from[k]);
}

/// What all Gaussians of a change share.
struct Change {
  explicit Change(const Similarity& b_from_a)
      : world(b_from_a),
        quaternion(quaternion_from_rotation(b_from_a.rotation)),
        log_scale(std::log(b_from_a.scale)),
        sh(b_from_a.rotation) {}

  Similarity world;
  Vec4<double> quaternion;  // of the rotation
  double log_scale;
  ShRotation sh;
};

/// Quaternions and scales of one dynamic Gaussian.
void change_shape4(const Change& change, const GaussianSpans<float>& v, int64_t n) {
  const Vec4<double> left =
      quaternion_product(change.quaternion, Vec4<double>(load4(v.at(kRotation, n))));
  const Vec4<double> right = quaternion_product(Vec4<double>(load4(v.at(kRotationRight, n))),
                                                conjugate(change.quaternion));
  float* const log_scale = v.at(kLogScale, n);
  float* const log_scale_time = v.at(kLogScaleTime, n);
  const double sigma[4] = {std::exp(double(*log_scale_time)), std::exp(double(log_scale[0])),
                           std::exp(double(log_scale[1])), std::exp(double(log_scale[2]))};
  Shape4 shape{left, right, {sigma[0], sigma[1], sigma[2], sigma[3]}};
  if (scale_space(change.world.scale, shape)) {
    *log_scale_time = float(std::log(shape.sigma[0]));
    for (int k = 0; k < 3; ++k) log_scale[k] = float(std::log(shape.sigma[k + 1]));
  } else {
    for (int k = 0; k < 3; ++k) log_scale[k] = float(double(log_scale[k]) + change.log_scale);
  }
  store4(shape.left, v.at(kRotation, n));
  store4(shape.right, v.at(kRotationRight, n));
}

/// A velocity is a difference of places.
void change_velocity(const Change& change, float* velocity) {
  const glm::dvec3 turned =
      change.world.rotation *
      glm::dvec3(double(velocity[0]), double(velocity[1]), double(velocity[2]));
  for (int k = 0; k < 3; ++k) velocity[k] = float(change.world.scale * turned[k]);
}

void change_gaussian(const Change& change, const GaussianSpans<float>& v, int64_t n) {
  float* const mean = v.at(kMean, n);
  const glm::dvec3 moved = change.world({double(mean[0]), double(mean[1]), double(mean[2])});
  for (int k = 0; k < 3; ++k) mean[k] = float(moved[k]);
  if (v.form == SetForm::kPair) {
    change_shape4(change, v, n);
  } else {
    float* const log_scale = v.at(kLogScale, n);
    for (int k = 0; k < 3; ++k) log_scale[k] = float(double(log_scale[k]) + change.log_scale);
    store4(quaternion_product(change.quaternion, Vec4<double>(load4(v.at(kRotation, n)))),
           v.at(kRotation, n));
  }
  if (v.form == SetForm::kVelocity) change_velocity(change, v.at(kVelocity, n));
  change.sh.apply(v.coefficients, v.at(kSh, n));
  for (int level = 0; level < v.time_levels; ++level)
    change.sh.apply(v.coefficients, v.at(kShTime, n) + level * v.width(kSh));
}

void change_set(const Change& change, GaussianSet& set) {
  const GaussianSpans<float> values = set.values();
  parallel_for(set.count(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) change_gaussian(change, values, n);
  });
}

/// Nodes move as points do, their translations as velocities; their rotations turn in the other
/// axes.
void change_nodes(const Change& change, MotionNodes& nodes) {
  for (int64_t m = 0; m < nodes.count; ++m) {
    float* const p = nodes.position.data() + 3 * m;
    const glm::dvec3 moved = change.world({double(p[0]), double(p[1]), double(p[2])});
    for (int k = 0; k < 3; ++k) p[k] = float(moved[k]);
    float& log_radius = nodes.log_radius.value[m];
    log_radius = float(double(log_radius) + change.log_scale);
  }
  for (int64_t i = 0; i < nodes.count * nodes.knots; ++i) {
    change_velocity(change, nodes.translation.value.data() + 3 * i);
    float* const q = nodes.rotation.value.data() + 4 * i;
    const glm::dvec3 axis = change.world.rotation * glm::dvec3(q[1], q[2], q[3]);
    for (int k = 0; k < 3; ++k) q[k + 1] = float(axis[k]);
  }
}

}  // namespace

void flip_axes(GaussianSet& set, const AxisSigns& s) {
  check(set.form() != SetForm::kPair, "flip_axes: a set whose velocities are stored");
  check(s.x * s.y * s.z == 1, "flip_axes: signs of a rotation");
  const GaussianSpans<float> values = set.values();
  const float mean[3] = {s.x, s.y, s.z};
  const float rotation[4] = {1, s.y * s.z, s.x * s.z, s.x * s.y};
  const auto sh = sh_signs(s);
  for (int64_t n = 0; n < set.count(); ++n) {
    for (int k = 0; k < 3; ++k) values.at(kMean, n)[k] *= mean[k];
    for (int k = 0; k < 3 && set.form() == SetForm::kVelocity; ++k)
      values.at(kVelocity, n)[k] *= mean[k];
    for (int k = 0; k < 4; ++k) values.at(kRotation, n)[k] *= rotation[k];
    for (int i = 1; i < set.coefficients(); ++i)
      for (int c = 0; c < 3; ++c) values.at(kSh, n)[3 * i + c] *= sh[size_t(i)];
  }
}

GaussianModel model_in_world(const Similarity& b_from_a, const GaussianModel& model) {
  GaussianModel moved = model.clone_values();
  if (b_from_a.is_identity()) return moved;
  const Change change(b_from_a);
  change_set(change, moved.static_set);
  change_set(change, moved.dynamic_set);
  change_nodes(change, moved.nodes);
  moved.environment.map_from_world =
      model.environment.map_from_world * glm::transpose(b_from_a.rotation);
  moved.drawing.near_plane *= b_from_a.scale;
  moved.drawing.far_plane *= b_from_a.scale;
  moved.prepared_from_source = compose(b_from_a, model.prepared_from_source);
  return moved;
}

GaussianModel model_in_source_world(const GaussianModel& model) {
  constexpr double kPreparedSize =
      4;  // units that cameras of a prepared world stand from its centre
  const Similarity source_from_prepared = inverse(model.prepared_from_source);
  const glm::dvec3 origin =
      far_origin(source_from_prepared.translation, kPreparedSize * source_from_prepared.scale);
  GaussianModel moved = model_in_world(compose(less(origin), source_from_prepared), model);
  moved.prepared_from_source = less(origin);
  return moved;
}

}  // namespace tessera
