// Pieces of each Gaussian, and their opacities.
#include "static3d/line_motion/piece_lines.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/parallel.h"

namespace tessera {
namespace {

float shared_logit(float logit, double share) {
  const double whole = 1 / (1 + std::exp(-double(logit)));
  const double opacity = piece_opacity(std::min(whole * share, 1.0));
  return float(std::log(opacity / (1 - opacity)));
}

void set_line(const LinePiece& piece, const GaussianSpans<float>& to, int64_t n) {
  for (int k = 0; k < 3; ++k) {
    to.at(kMean, n)[k] = float(piece.mean[k]);
    to.at(kVelocity, n)[k] = float(piece.velocity[k]);
  }
  for (int k = 0; k < 4; ++k) to.at(kRotation, n)[k] = float(piece.rotation[k]);
  *to.at(kMeanTime, n) = float(piece.time);
  *to.at(kLogScaleTime, n) = float(std::log(piece.extent));
}

}  // namespace

Vec3<double> scale_of(const GaussianSpans<const float>& set, int64_t n) {
  const float* const scale = set.at(kLogScale, n);
  return glm::exp(Vec3<double>(scale[0], scale[1], scale[2]));
}

LinePiece line_at(const GaussianSpans<const float>& lines, int64_t n) {
  const float* const mean = lines.at(kMean, n);
  const float* const v = lines.at(kVelocity, n);
  const float* const turn = lines.at(kRotation, n);
  return {double(*lines.at(kMeanTime, n)),
          std::exp(double(*lines.at(kLogScaleTime, n))),
          {mean[0], mean[1], mean[2]},
          {v[0], v[1], v[2]},
          {turn[0], turn[1], turn[2], turn[3]}};
}

PieceLines lines_of_pieces(const GaussianSet& shapes,
                           const std::function<std::vector<LinePiece>(int64_t)>& pieces_of) {
  constexpr int64_t kGrain = 16;
  const GaussianSpans<const float> from = shapes.values();
  std::vector<std::vector<LinePiece>> pieces(size_t(shapes.count()));
  parallel_for(shapes.count(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) pieces[size_t(n)] = pieces_of(n);
  });
  PieceLines made{GaussianSet(SetForm::kVelocity, shapes.coefficients())};
  int64_t count = 0;
  for (const auto& of_one : pieces) count += int64_t(of_one.size());
  made.lines.resize(count);
  const GaussianSpans<float> to = made.lines.values();
  int64_t line = 0;
  for (int64_t n = 0; n < shapes.count(); ++n) {
    made.bent += pieces[size_t(n)].size() > 1;
    for (const LinePiece& piece : pieces[size_t(n)]) {
      for (const Group g : {kLogScale, kSh})
        std::copy_n(from.at(g, n), shapes.width(g), to.at(g, line));
      const float logit = *from.at(kOpacityLogit, n);
      *to.at(kOpacityLogit, line) = piece.is_part ? shared_logit(logit, piece.share) : logit;
      set_line(piece, to, line++);
      if (pieces[size_t(n)].size() > 1)
        made.strays = std::max(made.strays, piece.strays / middle(scale_of(from, n)));
    }
  }
  return made;
}

}  // namespace tessera
