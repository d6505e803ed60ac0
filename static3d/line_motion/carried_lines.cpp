// Follows the Gaussians through the segments of the splines, a part of the set at a time.
#include "static3d/line_motion/carried_lines.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kernels/base/parallel.h"
#include "kernels/math/node_pose.h"
#include "recon4d/model/element_edits.h"
#include "static3d/line_motion/lines.h"
#include "static3d/line_motion/pieces.h"

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

/// A line and the row of the Gaussian that it is of.
struct Line {
  int64_t row;
  float logit;
  LinePiece piece;
};

float piece_logit(float logit) {
  const double opacity = piece_opacity(1 / (1 + std::exp(-double(logit))));
  return float(std::log(opacity / (1 - opacity)));
}

std::vector<LinePiece> pieces_of(const GaussianSet& part, const Carried<float>& carried,
                                 int64_t n) {
  std::vector<CarriedPoint> points;
  for (int64_t i = n; i < int64_t(carried.gaussians.size()); i += part.count()) {
    const CarriedGaussian<float>& g = carried.gaussians[i];
    points.push_back({Vec3<double>(g.mean), glm::normalize(Vec4<double>(g.rotation))});
  }
  const float* const scale = part.values().at(kLogScale, n);
  return line_pieces(points, glm::exp(Vec3<double>(scale[0], scale[1], scale[2])));
}

GaussianSet set_of(const GaussianSet& from, const std::vector<Line>& lines) {
  GaussianSet set(SetForm::kVelocity, from.coefficients());
  set.resize(int64_t(lines.size()));
  const GaussianSpans<const float> source = from.values();
  const GaussianSpans<float> target = set.values();
  for (int64_t n = 0; n < set.count(); ++n) {
    const auto& [row, logit, piece] = lines[size_t(n)];
    for (const Group g : {kLogScale, kSh})
      std::copy_n(source.at(g, row), from.width(g), target.at(g, n));
    *target.at(kOpacityLogit, n) = logit;
    for (int k = 0; k < 3; ++k) {
      target.at(kMean, n)[k] = float(piece.mean[k]);
      target.at(kVelocity, n)[k] = float(piece.velocity[k]);
    }
    for (int k = 0; k < 4; ++k) target.at(kRotation, n)[k] = float(piece.rotation[k]);
    *target.at(kMeanTime, n) = float(piece.time);
    *target.at(kLogScaleTime, n) = float(std::log(piece.extent));
  }
  return set;
}

}  // namespace

GaussianSet lines_of_carried(const GaussianSet& canonical, const MotionNodes& nodes) {
  constexpr int64_t kRows = 1024, kGrain = 16;
  const GaussianSet sound = select_elements(canonical, valid_elements(canonical));
  const std::unique_ptr<Backend> host = make_cpu_backend();
  const ViewBatch<float> batch = make_view_batch<float>(views_through(nodes.knots));
  std::vector<Line> lines;
  for (int64_t first = 0; first < sound.count(); first += kRows) {
    std::vector<int64_t> rows(size_t(std::min(kRows, sound.count() - first)));
    std::iota(rows.begin(), rows.end(), first);
    const GaussianSet part = select_elements(sound, rows);
    Carried<float> carried;
    host->carry({&batch, part.values(), nodes.spans()}, carried);
    std::vector<std::vector<LinePiece>> pieces(rows.size());
    parallel_for(part.count(), kGrain, [&](int64_t begin, int64_t end) {
      for (int64_t n = begin; n < end; ++n) pieces[size_t(n)] = pieces_of(part, carried, n);
    });
    for (int64_t n = 0; n < part.count(); ++n) {
      const float logit = *part.values().at(kOpacityLogit, n);
      const float each = pieces[size_t(n)].size() == 1 ? logit : piece_logit(logit);
      for (const LinePiece& piece : pieces[size_t(n)]) lines.push_back({first + n, each, piece});
    }
  }
  return set_of(sound, lines);
}

}  // namespace tessera
