// The search along the ray of a pixel for the depth at which other cameras agree with it: planes of
// equal steps in inverse depth by grey patches at whole pixels, then between planes by patches in
// colour. Source: plane sweep [Collins96].
#pragma once
#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "ingest/cloud/patch.h"
#include "ingest/scene.h"

namespace tessera {

/// A camera along another's ray: pixel position at inverse depth w of that ray, (a + w b) / z.
struct RaySight {
  const Image8* image;
  const FrameMask* mask;
  const GreyImage* grey;
  const Camera* camera;
  int frame;
  glm::dvec3 a, b;

  /// Whether the camera has a patch there, whatever its mask ignores; without branches, for loops
  /// over planes.
  bool has_patch_at(double w, double& u, double& v) const {
    constexpr double kBorder = Patch::kBorder;
    const double right = image->width - kBorder, bottom = image->height - kBorder;
    const glm::dvec3 p = a + w * b;
    u = camera->fl_x * p.x / p.z + camera->cx;
    v = camera->fl_y * p.y / p.z + camera->cy;
    return p.z > 0 && u >= kBorder && v >= kBorder && u < right && v < bottom;
  }
  /// False behind the camera, at or outside the edge of its image, or where its mask ignores the
  /// pixel.
  bool at(double w, double& u, double& v) const {
    return has_patch_at(w, u, v) && !mask->ignores(int(u), int(v));
  }
};

class RaySearch {
 public:
  static constexpr size_t kMostSights = 8;
  static constexpr int kMostPlanes = 256;

  /// Inverse depths farthest + step · plane.
  struct Planes {
    double farthest, step;
    int count;  // up to kMostPlanes
  };

  /// Around a pixel, in colour and in grey; at most kMostSights of other cameras.
  RaySearch(const Patch& patch, const GreyPatch& grey, std::vector<RaySight> sights, Planes planes)
      : patch_(patch), grey_(grey), sights_(std::move(sights)), planes_(planes) {}

  double inverse(double plane) const { return planes_.farthest + planes_.step * plane; }

  /// The best plane, if no other valley is nearly as deep.
  std::optional<int> best_plane() const;
  /// Between planes: bilinear patches in fine steps, then the vertex of the parabola through the
  /// best and its neighbours.
  double refined(int plane) const;
  /// Levels, in colour and between pixels; `best` becomes the frame that agrees most.
  float fine(double plane, int& best) const;

 private:
  using PlaneCosts = std::array<float, size_t(kMostPlanes)>;

  /// Levels, in grey and at whole pixels, at every plane; kAbsent where it is not compared.
  void compare(const RaySight& sight, PlaneCosts& costs) const;

  Patch patch_;
  GreyPatch grey_;
  std::vector<RaySight> sights_;
  Planes planes_;
};

/// Difference of the brightness of patches that may agree, levels.
inline constexpr float kMostGain = 48;

}  // namespace tessera
