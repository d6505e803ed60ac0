// The .ply of SpacetimeGaussians, "lite": means of the third degree in time, quaternions of the
// first, p = exp(−(dt / exp(trbf_scale))²) of opacity, colours as they are; normalised time, of a
// clip whose seconds are not stated. Source: Li et al. 2024, "Spacetime Gaussian Feature Splatting
// for Real-Time Dynamic View Synthesis", equations 7 to 9; the columns are those that its program
// writes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/math/spherical_harmonics.h"
#include "recon4d/model/element_edits.h"
#include "static3d/line_motion/line_columns.h"
#include "static3d/line_motion/line_formats.h"
#include "static3d/line_motion/lines.h"
#include "static3d/line_motion/piece_lines.h"

namespace tessera {
namespace {

constexpr int kMotionDegree = 3;
constexpr float kMostLogExtent = 30;  // of σ_t: beyond it, its square has no number

const std::vector<ForeignName>& spacetime_names() {
  static const std::vector<ForeignName> rows{{"trbf_center", "mean_time"},
                                             {"trbf_scale", "scale_time"},
                                             {"motion_0", "velocity_0"},
                                             {"motion_1", "velocity_1"},
                                             {"motion_2", "velocity_2"}};
  return rows;
}

/// Motion and turning of each Gaussian, beyond its line.
class Motions {
 public:
  Motions(const std::filesystem::path& path, const PlyElement& vertex)
      : values_(read_floats(path, vertex, column_names())) {}

  /// Of Gaussian n of `lines`, at dt from its centre.
  CarriedPoint at(const GaussianSpans<const float>& lines, int64_t n, double dt) const {
    const float* const mean = lines.at(kMean, n);
    const float* const rotation = lines.at(kRotation, n);
    const float* const motion = values_.data() + n * (kMotions + 4);
    CarriedPoint point{{mean[0], mean[1], mean[2]},
                       {rotation[0], rotation[1], rotation[2], rotation[3]}};
    for (int k = 0; k < 3; ++k)
      for (int degree = kMotionDegree; degree > 0; --degree)
        point.mean[k] += double(motion[3 * (degree - 1) + k]) * std::pow(dt, degree);
    for (int k = 0; k < 4; ++k) point.rotation[k] += double(motion[kMotions + k]) * dt;
    const double length = glm::length(point.rotation);
    point.rotation = length > 0 ? point.rotation / length : Vec4<double>(1, 0, 0, 0);
    return point;
  }

 private:
  static constexpr int kMotions = 3 * kMotionDegree;

  static std::vector<std::string> column_names() {
    std::vector<std::string> names;
    for (int i = 0; i < kMotions; ++i) names.push_back(fmt::format("motion_{}", i));
    for (int i = 0; i < 4; ++i) names.push_back(fmt::format("omega_{}", i));
    return names;
  }

  const std::vector<float> values_;  // [N, kMotions + 4]
};

/// Through the part of the clip in which it is seen; none where that is none, and of what is no
/// number.
std::optional<Curve> curve_of(const Motions& motions, const GaussianSpans<const float>& lines,
                              int64_t n) {
  constexpr double kSeen = 2.5;  // deviations: 4 % of opacity are left
  constexpr int kPoints = 129;
  Curve curve;
  curve.centre = *lines.at(kMeanTime, n);
  curve.extent = std::exp(double(*lines.at(kLogScaleTime, n)));
  const double reach = kSeen * curve.extent;
  curve.time = {std::max(0.0, curve.centre - reach), std::min(1.0, curve.centre + reach)};
  if (!(curve.time.low < curve.time.high) || !is_valid_element(lines, n)) return std::nullopt;
  for (int i = 0; i < kPoints; ++i) {
    const double time = curve.time.low + (curve.time.high - curve.time.low) * i / (kPoints - 1);
    curve.points.push_back(motions.at(lines, n, time - curve.centre));
  }
  return curve;
}

}  // namespace

LineFile load_spacetime_ply(const std::filesystem::path& path, const PlyFile& file) {
  GaussianSet lines = read_lines(path, file, spacetime_names());
  const PlyElement& vertex = *file.find("vertex");
  if (vertex.find("f_t_0") != nullptr)
    throw InputError(
        fmt::format("{}: colours are features that a network decodes (columns f_t), which are not "
                    "read; train the lite model of SpacetimeGaussians",
                    path.string()));
  const GaussianSpans<float> values = lines.values();
  for (int64_t n = 0; n < lines.count(); ++n) {
    float& extent = *values.at(kLogScaleTime, n);
    extent = std::clamp(extent - float(0.5 * std::numbers::ln2), -kMostLogExtent, kMostLogExtent);
    for (int k = 0; k < 3; ++k) {
      float& colour = values.at(kSh, n)[k];
      colour = (colour - 0.5f) / float(kSh0);
    }
  }
  const Motions motions(path, vertex);
  const GaussianSpans<const float> read = std::as_const(lines).values();
  const PieceLines made = lines_of_pieces(lines, [&](int64_t n) {
    const std::optional<Curve> curve = curve_of(motions, read, n);
    return curve ? line_pieces(*curve, scale_of(read, n)) : std::vector{line_at(read, n)};
  });
  LineFile loaded{model_of_lines(made.lines, {0, (kUnstatedFrames - 1) / kUnstatedRate, false}),
                  {}};
  if (made.bent > 0)
    loaded.warnings.push_back(fmt::format(
        "{}: {} of {} Gaussians move along curves and are {} lines, which stray by up to {:.2f} of "
        "a Gaussian's middle scale",
        path.string(), made.bent, lines.count(), made.lines.count() - (lines.count() - made.bent),
        made.strays));
  return loaded;
}

}  // namespace tessera
