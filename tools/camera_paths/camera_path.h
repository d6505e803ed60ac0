// Camera paths: an orbit around the centre of a rig, a spiral in front of it, and curves through
// key frames. The spiral is the render path of [LLFF]; key frames are joined by Catmull-Rom splines
// and slerp.
#pragma once
#include <glm/gtc/quaternion.hpp>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

/// The facts of a scene that an orbit depends on, world units.
struct OrbitFrame {
  glm::dvec3 centre{0.0};
  glm::dvec3 up{0, 0, 1};     // unit
  glm::dvec3 start{1, 0, 0};  // unit, across `up`: the side from which the first camera looks
  double radius = 1;          // of the circle, > 0
  double height = 0;          // of the circle's plane above the centre
};

/// Of a rig: centre and up as world_normalisation.h finds them (the point nearest to the optical
/// axes, outlying ones weighted down; where they do not meet, at the median depth of `points`),
/// radius and height the medians of the cameras', start at the cameras' mean. `rig` must not be
/// empty. Errors: InputError: cameras that all stand on the axis of the circle.
OrbitFrame orbit_of_rig(const std::vector<Camera>& rig, const PointCloud& points);

/// Around a box without cameras: so far away that its sphere fills the image of `lens`, 20
/// degrees above its middle.
OrbitFrame orbit_of_box(const glm::dvec3& centre, double half_extent, const glm::dvec3& up,
                        const Camera& lens);

/// Whether the rig's cameras, seen along `up`, look into one half-plane: an orbit goes behind what
/// they saw.
bool looks_one_way(const std::vector<Camera>& rig, const glm::dvec3& up);

/// `count` cameras with the lens of `lens` (size, focal lengths, principal point) that look at the
/// centre, `up` up, evenly once around; the last is one step before the first.
std::vector<Camera> orbit_path(const OrbitFrame& frame, const Camera& lens, int64_t count);

/// `count` cameras on two turns about the rig's mean camera that look at the point where it looks,
/// at the depth of the rig's centre; the last is one step before the first. From the mean, no axis
/// leaves the 90 % quantile of the rig's cameras. `rig` must not be empty. Errors: InputError where
/// the cameras look all ways or stand in one place.
std::vector<Camera> spiral_path(const std::vector<Camera>& rig, const PointCloud& points,
                                const Camera& lens, int64_t count);

/// `count` cameras from the first key to the last; where i·(K − 1)/(count − 1) is whole it is that
/// key, bit for bit. Between: centres by Catmull-Rom, rotations by slerp on the shorter way, lenses
/// linear. `keys` must not be empty and have one size.
std::vector<Camera> key_path(const std::vector<Camera>& keys, int64_t count);

/// Where camera i of `count` is between K keys: key and share of the way to the next.
struct KeyPlace {
  int64_t key = 0;
  double share = 0;  // [0, 1); 0 at the last key
};
KeyPlace key_place(int64_t i, int64_t count, int64_t keys);

/// The camera with another image size: the vertical field of view stays, pixels keep their shape,
/// the principal point its offset from the middle.
Camera with_size(const Camera& camera, int width, int height);

}  // namespace tessera
