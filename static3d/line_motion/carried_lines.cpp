// Follows the Gaussians through the segments of the splines, a part of the set at a time.
#include "static3d/line_motion/carried_lines.h"

#include <algorithm>
#include <numeric>

#include "kernels/math/node_pose.h"
#include "recon4d/model/element_edits.h"
#include "static3d/line_motion/lines.h"
#include "static3d/line_motion/piece_lines.h"

namespace tessera {
namespace {

/// Views at even times from 0 to 1, four in each segment of the splines.
std::vector<View> views_through(int knots) {
  constexpr int kEach = 4;
  const int steps = kEach * (knots - kSplineOrder + 1);
  std::vector<View> views;
  for (int i = 0; i <= steps; ++i) views.push_back({Camera{}, double(i) / steps});
  return views;
}

}  // namespace

GaussianSet lines_of_carried(const GaussianSet& canonical, const MotionNodes& nodes) {
  constexpr int64_t kRows = 1024;
  const GaussianSet sound = select_elements(canonical, valid_elements(canonical));
  const std::unique_ptr<Backend> host = make_cpu_backend();
  const ViewBatch<float> batch = make_view_batch<float>(views_through(nodes.knots));
  std::vector<GaussianSet> parts;
  for (int64_t first = 0; first < sound.count(); first += kRows) {
    std::vector<int64_t> rows(size_t(std::min(kRows, sound.count() - first)));
    std::iota(rows.begin(), rows.end(), first);
    const GaussianSet part = select_elements(sound, rows);
    Carried<float> carried;
    host->carry({&batch, part.values(), nodes.spans()}, carried);
    const auto pieces_of = [&](int64_t n) {
      Curve curve;
      for (int64_t i = n; i < int64_t(carried.gaussians.size()); i += part.count()) {
        const CarriedGaussian<float>& g = carried.gaussians[i];
        curve.points.push_back({Vec3<double>(g.mean), glm::normalize(Vec4<double>(g.rotation))});
      }
      return line_pieces(curve, scale_of(part.values(), n));
    };
    parts.push_back(lines_of_pieces(part, pieces_of).lines);
  }
  return joined_lines(parts);
}

}  // namespace tessera
