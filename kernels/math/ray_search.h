// The search along the ray of a pixel for the depth at which other cameras agree with it: what a
// camera is to another's ray, the costs of a depth, and the choice among them. On host and device
// alike. Source: plane sweep [Collins96].
#pragma once
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "kernels/base/camera.h"
#include "kernels/math/patch.h"

namespace tessera {

inline constexpr int kMostSights = 8;    // cameras that a pixel is compared with
inline constexpr int kMostPlanes = 256;  // of equal steps in inverse depth
inline constexpr int kFineSteps = 4;     // between planes, on either side of the best
inline constexpr float kMostGain =
    48;  // difference in brightness of patches that may agree, levels
inline constexpr float kNoAgreement = 1e9f;
inline constexpr float kNotCompared = 2e9f;  // of a camera

/// An image of a search: its camera, the images that it is compared with, those of its camera at
/// other times.
struct SearchView {
  RgbView image;
  const uint8_t* grey = nullptr;  // [height, width] grey_level
  const uint8_t* mask = nullptr;  // [height, width], 0: the pixel is ignored; null: all are used
  Camera camera;
  glm::dvec3 eye{0.0};  // Camera::position, world units
  double time = 0;      // normalised
  int others[kMostSights] = {};
  int other_count = 0;
  StillSight sights[kMostStillSights];
  int sight_count = 0;

  TESSERA_HD bool ignores(int x, int y) const {
    return mask != nullptr && mask[int64_t(y) * image.width + int64_t(x)] == 0;
  }
  TESSERA_HD bool moves(int x, int y) const {
    return has_patch(image, x, y) && !is_still(image, x, y, sights, sight_count);
  }
};

struct ViewPixel {
  int view, x, y;
};

struct RayQuery {
  ViewPixel pixel;
  glm::dvec3 velocity{0.0};  // of what it shows, world units per unit of normalised time
};

/// Where a search ended.
struct RayDepth {
  double inverse = 0;  // of the depth along the camera's axis; 0: nothing was found
  int best = -1;       // view that agrees most
  float cost = 0;      // levels
};

/// Depths that are looked at, as inverses.
struct DepthRange {
  double farthest, range;
};

/// Inverse depths farthest + step · plane.
struct RayPlanes {
  double farthest, step;
  int count;  // up to kMostPlanes

  TESSERA_HD double inverse(double plane) const { return farthest + step * plane; }
};

/// So many that a pixel moves by kPixelsAPlane from plane to plane in the other camera.
TESSERA_HD inline RayPlanes planes_of(const SearchView& view, const SearchView& median,
                                      const DepthRange& range) {
  constexpr double kPixelsAPlane = 1.5;
  constexpr int kFewestPlanes = 48;
  const double shift = median.camera.fl_x * glm::distance(median.eye, view.eye) * range.range;
  const double wanted = shift / kPixelsAPlane;
  const int count = wanted < kFewestPlanes ? kFewestPlanes
                    : wanted > kMostPlanes ? kMostPlanes
                                           : int(wanted);
  return {range.farthest, range.range / (count - 1), count};
}

/// Direction of depth 1, world units.
TESSERA_HD inline glm::dvec3 ray_of(const SearchView& view, int x, int y) {
  const Camera& camera = view.camera;
  return glm::transpose(camera.cam_from_world) *
         glm::dvec3((x + 0.5 - camera.cx) / camera.fl_x, (y + 0.5 - camera.cy) / camera.fl_y, 1);
}

/// A camera along another's ray: pixel position at inverse depth w of that ray, (a + w b) / z.
struct RaySight {
  const SearchView* view;
  int index;  // of the view
  glm::dvec3 a, b;

  /// Whether the camera has a patch there, whatever its mask ignores; without branches, for loops
  /// over planes.
  TESSERA_HD bool has_patch_at(double w, double& u, double& v) const {
    constexpr double kBorder = Patch::kBorder;
    const Camera& camera = view->camera;
    const double right = view->image.width - kBorder, bottom = view->image.height - kBorder;
    const glm::dvec3 p = a + w * b;
    u = camera.fl_x * p.x / p.z + camera.cx;
    v = camera.fl_y * p.y / p.z + camera.cy;
    return p.z > 0 && u >= kBorder && v >= kBorder && u < right && v < bottom;
  }
  /// False behind the camera, at or outside the edge of its image, or where its mask ignores the
  /// pixel.
  TESSERA_HD bool at(double w, double& u, double& v) const {
    return has_patch_at(w, u, v) && !view->ignores(int(u), int(v));
  }
};

/// What moves with `velocity` is seen by the other camera at its time.
TESSERA_HD inline RaySight sight_of(const SearchView& view, const glm::dvec3& ray,
                                    const glm::dvec3& velocity, const SearchView& other,
                                    int index) {
  const Camera& camera = other.camera;
  return {&other, index, camera.cam_from_world * ray,
          camera.cam_from_world * (view.eye + (other.time - view.time) * velocity) +
              camera.translation};
}

/// The cost of a sight at an inverse depth, in colour and between pixels, levels; kNotCompared
/// where it is not.
TESSERA_HD inline float fine_cost(const Patch& patch, const RaySight& sight, double w) {
  double u, v;
  if (!sight.at(w, u, v)) return kNotCompared;
  const Patch other = patch_between(sight.view->image, u, v);
  if (brightness_difference(patch, other) > kMostGain) return kNotCompared;
  return difference(patch, other);
}

/// Cameras of `count` whose mean is taken, so that occluded ones have no weight.
TESSERA_HD inline int better_half(int count) {
  return count < 4 ? 2 : (count + 1) / 2;
}

/// Of the four least costs of `seen` cameras, the mean of those of the better half.
TESSERA_HD inline float better_half_mean(float c0, float c1, float c2, float c3, int seen) {
  if (seen < 2) return kNoAgreement;
  const int half = better_half(seen);
  float sum = c0 + c1;
  sum += half > 2 ? c2 : 0.0f;
  sum += half > 3 ? c3 : 0.0f;
  return sum / float(half);
}

/// The mean over the better half of the cameras; `best` becomes the view that agrees most, the
/// first of equal ones.
TESSERA_HD inline float agreement(const float* costs, const RaySight* sights, int count,
                                  int& best) {
  float least[4] = {kNotCompared, kNotCompared, kNotCompared, kNotCompared};
  int seen = 0;
  best = -1;
  for (int i = 0; i < count; ++i) {
    float cost = costs[i];
    if (!(cost < kNotCompared)) continue;
    ++seen;
    if (cost < least[0] || (cost == least[0] && sights[i].index < best)) best = sights[i].index;
    for (float& kept : least)
      if (cost < kept) {
        const float next = kept;
        kept = cost;
        cost = next;
      }
  }
  return better_half_mean(least[0], least[1], least[2], least[3], seen);
}

/// Whether the valley around the best plane lets another one be nearly as deep.
TESSERA_HD inline bool is_rival(int plane, float cost, int best, float least) {
  constexpr int kValley = 3;          // planes on either side of the best that belong to it
  constexpr float kDistinct = 1.15f;  // second valley ÷ best
  return (plane < best - kValley || plane > best + kValley) && cost < kDistinct * least;
}

inline constexpr double kFineStep = 0.25;  // of a plane

/// Between planes, by the costs of fine steps around `plane`: the vertex of the parabola through
/// the best and its neighbours.
TESSERA_HD inline double refined_plane(int plane, const float* costs) {
  int best = 0;
  for (int i = 1; i <= 2 * kFineSteps; ++i)
    if (costs[i] < costs[best]) best = i;
  double vertex = 0;
  if (best > 0 && best < 2 * kFineSteps && costs[best - 1] < kNoAgreement &&
      costs[best + 1] < kNoAgreement) {
    const double a = costs[best - 1], b = costs[best], c = costs[best + 1];
    if (a - 2 * b + c > 0) vertex = 0.5 * (a - c) / (a - 2 * b + c);
  }
  return plane + kFineStep * (best - kFineSteps + vertex);
}

/// Most cost of patches that agree on what one of so much texture shows, levels.
TESSERA_HD inline float most_cost(float structure) {
  constexpr float kMostDifference = 12, kMostUnlike = 0.7f;
  const float by_texture = kMostUnlike * structure;
  return by_texture < kMostDifference ? by_texture : kMostDifference;
}

inline constexpr float kLeastTexture = 2;  // of a patch whose depth is looked for, levels

}  // namespace tessera
