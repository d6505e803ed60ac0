// Computes circle, spiral and spline as lists of poses.
#include "tools/camera_paths/camera_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ingest/poses/world_normalisation.h"
#include "kernels/base/errors.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

using glm::dmat3;
using glm::dquat;
using glm::dvec3;

constexpr double kElevation = 20 * std::numbers::pi / 180;  // of an orbit without a rig
constexpr double kTurns = 2, kDepthRate = 0.5;              // of the spiral  [LLFF]
constexpr double kSpread = 0.9;                             // quantile of the rig  [LLFF]
constexpr double kOneWay = 0.5;  // length of the mean viewing direction: cos 60°

dvec3 forward_of(const Camera& camera) {
  return glm::transpose(camera.cam_from_world)[2];
}

dvec3 mean_position(const std::vector<Camera>& rig) {
  dvec3 mean(0.0);
  for (const Camera& camera : rig) mean += camera.position() / double(rig.size());
  return mean;
}

void place(Camera& camera, const dmat3& cam_from_world, const dvec3& position) {
  camera.cam_from_world = cam_from_world;
  camera.translation = -(cam_from_world * position);
}

/// A unit vector across the unit vector `up`.
dvec3 any_across(const dvec3& up) {
  const dvec3 axis = std::abs(up.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  return glm::normalize(axis - up * glm::dot(axis, up));
}

/// `lens` at `position`, looking at `target`; +y of the camera is down.
Camera look_at(const Camera& lens, const dvec3& position, const dvec3& target, const dvec3& up) {
  const dvec3 forward = glm::normalize(target - position);
  dvec3 right = glm::cross(forward, up);
  right = glm::length(right) > 1e-9 ? glm::normalize(right) : any_across(forward);
  Camera camera = lens;
  place(camera, glm::transpose(dmat3(right, glm::cross(forward, right), forward)), position);
  return camera;
}

/// Interpolates four values a step apart between b and c: hits b at 0 and c at 1.
dvec3 catmull_rom(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& d, double s) {
  return b +
         0.5 * s * (c - a + s * (2.0 * a - 5.0 * b + 4.0 * c - d + s * (3.0 * (b - c) + d - a)));
}

Camera between(const std::vector<Camera>& keys, const KeyPlace& at_key) {
  const auto position = [&](int64_t k) {
    const int64_t last = int64_t(keys.size()) - 1;
    // beyond the ends the path goes straight on
    if (k < 0) return 2.0 * keys[0].position() - keys[1].position();
    if (k > last) return 2.0 * keys[size_t(last)].position() - keys[size_t(last - 1)].position();
    return keys[size_t(k)].position();
  };
  const Camera &a = keys[size_t(at_key.key)], &b = keys[size_t(at_key.key + 1)];
  const double s = at_key.share;
  const auto mix = [s](double x, double y) { return x + s * (y - x); };
  Camera camera = a;
  camera.fl_x = mix(a.fl_x, b.fl_x);
  camera.fl_y = mix(a.fl_y, b.fl_y);
  camera.cx = mix(a.cx, b.cx);
  camera.cy = mix(a.cy, b.cy);
  const dquat turned =
      glm::slerp(glm::quat_cast(a.cam_from_world), glm::quat_cast(b.cam_from_world), s);
  place(camera, glm::mat3_cast(glm::normalize(turned)),
        catmull_rom(position(at_key.key - 1), position(at_key.key), position(at_key.key + 1),
                    position(at_key.key + 2), s));
  return camera;
}

}  // namespace

bool looks_one_way(const std::vector<Camera>& rig, const dvec3& up) {
  dvec3 sum(0.0);
  double lengths = 0;
  for (const Camera& camera : rig) {
    const dvec3 forward = forward_of(camera);
    const dvec3 level = forward - up * glm::dot(forward, up);
    sum += level;
    lengths += glm::length(level);
  }
  return glm::length(sum) > kOneWay * lengths;
}

OrbitFrame orbit_of_rig(const std::vector<Camera>& rig, const PointCloud& points) {
  const Similarity world_from_level = inverse(normalised_from_source(rig, points));
  OrbitFrame frame;
  frame.centre = world_from_level.translation;
  frame.up = world_from_level.rotation[2];
  std::vector<double> radii, heights;
  for (const Camera& camera : rig) {
    const dvec3 arm = camera.position() - frame.centre;
    heights.push_back(glm::dot(arm, frame.up));
    radii.push_back(glm::length(arm - frame.up * heights.back()));
  }
  frame.radius = quantile(radii, 0.5);
  frame.height = quantile(heights, 0.5);
  if (!(frame.radius > 1e-6 * std::abs(frame.height)) || !(frame.radius > 0))
    throw InputError(
        "render: --path orbit: the cameras look straight up or down, which gives a circle no "
        "radius; pass a transforms file as --path");
  dvec3 side = mean_position(rig) - frame.centre;
  side -= frame.up * glm::dot(side, frame.up);
  const bool one_sided = glm::length(side) > 1e-3 * frame.radius;
  frame.start = one_sided ? glm::normalize(side) : any_across(frame.up);
  return frame;
}

OrbitFrame orbit_of_box(const dvec3& centre, double half_extent, const dvec3& up,
                        const Camera& lens) {
  const double tangent = 0.5 * std::min(lens.width / lens.fl_x, lens.height / lens.fl_y);
  const double distance = std::max(half_extent, 1e-6) / std::sin(std::atan(tangent));
  return {centre, up, any_across(up), distance * std::cos(kElevation),
          distance * std::sin(kElevation)};
}

std::vector<Camera> orbit_path(const OrbitFrame& frame, const Camera& lens, int64_t count) {
  const dvec3 side = glm::cross(frame.up, frame.start);
  std::vector<Camera> path;
  for (int64_t i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * double(i) / double(count);
    const dvec3 arm = frame.radius * (std::cos(angle) * frame.start + std::sin(angle) * side);
    path.push_back(
        look_at(lens, frame.centre + arm + frame.height * frame.up, frame.centre, frame.up));
  }
  return path;
}

std::vector<Camera> spiral_path(const std::vector<Camera>& rig, const PointCloud& points,
                                const Camera& lens, int64_t count) {
  dvec3 forward(0.0);
  for (const Camera& camera : rig) forward += forward_of(camera) / double(rig.size());
  if (glm::length(forward) < kOneWay)
    throw InputError(
        "render: --path spiral: the cameras look all ways, a spiral is for rigs that look one way; "
        "pass --path orbit");
  const Similarity world_from_level = inverse(normalised_from_source(rig, points));
  const dvec3 centre = world_from_level.translation, up = world_from_level.rotation[2];
  const dvec3 middle = mean_position(rig);
  const Camera mean = look_at(lens, middle, middle + forward, up);
  const double depth = glm::dot(centre - middle, forward_of(mean));
  std::vector<double> spread[3];
  for (const Camera& camera : rig)
    for (int k = 0; k < 3; ++k)
      spread[k].push_back(std::abs((mean.cam_from_world * (camera.position() - middle))[k]));
  const dvec3 reach(quantile(spread[0], kSpread), quantile(spread[1], kSpread),
                    quantile(spread[2], kSpread));
  if (!(glm::length(reach) > 1e-9 * (glm::length(middle) + depth)))
    throw InputError(
        "render: --path spiral: the cameras stand in one place; pass --path orbit or a transforms "
        "file");
  if (!(depth > 1e-6 * glm::length(reach)))
    throw InputError(
        "render: --path spiral: nothing lies before the cameras to look at; pass a transforms file "
        "as "
        "--path");
  const dvec3 target = middle + depth * forward_of(mean);
  std::vector<Camera> path;
  for (int64_t i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * kTurns * double(i) / double(count);
    const dvec3 offset =
        reach * dvec3(std::cos(angle), std::sin(angle), std::sin(kDepthRate * angle));
    path.push_back(
        look_at(lens, middle + glm::transpose(mean.cam_from_world) * offset, target, up));
  }
  return path;
}

KeyPlace key_place(int64_t i, int64_t count, int64_t keys) {
  if (count < 2 || keys < 2) return {};
  // whole numbers, so that a key is hit exactly
  const int64_t steps = i * (keys - 1);
  return {steps / (count - 1), double(steps % (count - 1)) / double(count - 1)};
}

std::vector<Camera> key_path(const std::vector<Camera>& keys, int64_t count) {
  std::vector<Camera> path;
  for (int64_t i = 0; i < count; ++i) {
    const KeyPlace key = key_place(i, count, int64_t(keys.size()));
    path.push_back(key.share == 0 ? keys[size_t(key.key)] : between(keys, key));
  }
  return path;
}

Camera with_size(const Camera& camera, int width, int height) {
  const double scale = double(height) / camera.height;
  Camera sized = camera;
  sized.width = width;
  sized.height = height;
  sized.fl_x *= scale;
  sized.fl_y *= scale;
  sized.cx = 0.5 * width + scale * (camera.cx - 0.5 * camera.width);
  sized.cy = 0.5 * height + scale * (camera.cy - 0.5 * camera.height);
  return sized;
}

}  // namespace tessera
