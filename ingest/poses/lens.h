// A lens: the image position of the ray of an ideal pinhole. RigCamera is a camera of a rig with
// its lens.
#pragma once
#include <glm/vec2.hpp>
#include <optional>
#include <string>

#include "kernels/base/camera.h"

namespace tessera {

/// (x, y) = ray with z = 1. First the projection bends it: ρ = r (pinhole), atan r (fisheye),
/// atan(2 r tan(ω/2)) / ω (field of view). Then, with r² of the bent ray:
/// x' = x·(1 + k1 r² + k2 r⁴ + k3 r⁶ + k4 r⁸) / (1 + d1 r² + d2 r⁴ + d3 r⁶)
///      + 2 p1 x y + p2 (r² + 2 x²) + s1 r², and y' alike with p1, p2 exchanged and s2.
struct Lens {
  enum class Projection { kPinhole, kFisheye, kFieldOfView };
  Projection projection = Projection::kPinhole;
  double k1 = 0, k2 = 0, k3 = 0, k4 = 0;  // radial
  double d1 = 0, d2 = 0, d3 = 0;          // radial, below the line
  double p1 = 0, p2 = 0;                  // tangential
  double s1 = 0, s2 = 0;                  // thin prism
  double omega = 0;                       // radians, of the field-of-view projection

  bool operator==(const Lens&) const = default;
  /// True where `distorted` changes nothing.
  bool is_pinhole() const;
  glm::dvec2 distorted(const glm::dvec2& ray) const;
  /// The ray that `distorted` takes to `met`; nothing where none was found (beyond the turning
  /// point of a distortion that turns back, or a fisheye's 90 degrees).
  std::optional<glm::dvec2> undistorted(const glm::dvec2& met) const;
  /// The length, `to` at most, up to which longer rays are met farther out, from rays of the length
  /// `from` on: beyond it `distorted` comes back, to places of other rays.
  double outward_reach(double from, double to) const;
};

struct RigCamera {
  std::string name;                    // "cam02": the name of its video without extension
  Camera camera;                       // size and intrinsics of the upright image, and its pose
  Lens lens;                           // what the image has beyond the pinhole
  std::string lens_model = "PINHOLE";  // COLMAP's name of it
  bool estimated = false;              // by COLMAP, not stated
  /// Mean over the points that COLMAP triangulated from it, pixels; absent where it gave none.
  std::optional<double> reprojection_error{};
};

}  // namespace tessera
