// Sums over SSIM maps, in double.
#include "recon4d/evaluation/structure_scores.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/base/parallel.h"
#include "kernels/stages/ssim_window.h"

namespace tessera {
namespace {

struct Plane {
  int width = 0, height = 0;
  std::vector<double> value;  // [height, width] in [0, 1]

  Plane(int w, int h) : width(w), height(h), value(size_t(w) * size_t(h)) {}
  Plane(const Image8& image, int channel) : Plane(image.width, image.height) {
    for (size_t p = 0; p < value.size(); ++p)
      value[p] = image.data[3 * p + size_t(channel)] / 255.0;
  }
};

/// The moments of a channel; b is a where the mask ignores.
MomentPlanes<double> moments_of(const Plane& x, Plane y, Padding padding,
                                Span<const uint8_t> mask) {
  for (size_t p = 0; p < x.value.size(); ++p)
    if (!is_used(mask, p)) y.value[p] = x.value[p];
  MomentPlanes<double> moments;
  moments.compute(x.value.data(), y.value.data(), x.width, x.height, padding);
  return moments;
}

double mean_ssim(const MomentPlanes<double>& moments, Span<const uint8_t> mask) {
  double sum = 0;
  const size_t pixels = moments.x.size();
  for (size_t p = 0; p < pixels; ++p)
    if (is_used(mask, p)) sum += moments.point(p).value;
  return sum / double(used_pixels(mask, pixels));
}

/// Over the used pixels whose window lies inside the image.
std::optional<double> mean_inside(const MomentPlanes<double>& moments, int width, int height,
                                  double range, Span<const uint8_t> mask) {
  double sum = 0;
  int64_t count = 0;
  const double c1 = kSsimC1<double> * range * range, c2 = kSsimC2<double> * range * range;
  for (int y = kSsimRadius; y < height - kSsimRadius; ++y)
    for (int x = kSsimRadius; x < width - kSsimRadius; ++x) {
      const size_t p = size_t(y) * size_t(width) + size_t(x);
      if (!is_used(mask, p)) continue;
      const auto [A, B, C, D] = ssim_terms(moments.moments(p), c1, c2);
      sum += C * D / (A * B);
      ++count;
    }
  if (count == 0) return std::nullopt;
  return sum / double(count);
}

/// Means of 2 × 2 pixels.
Plane halved(const Plane& from) {
  Plane to(from.width / 2, from.height / 2);
  const auto value = [&](int x, int y) {
    return from.value[size_t(y) * size_t(from.width) + size_t(x)];
  };
  for (int y = 0; y < to.height; ++y)
    for (int x = 0; x < to.width; ++x)
      to.value[size_t(y) * size_t(to.width) + size_t(x)] =
          (value(2 * x, 2 * y) + value(2 * x + 1, 2 * y) + value(2 * x, 2 * y + 1) +
           value(2 * x + 1, 2 * y + 1)) /
          4;
  return to;
}

/// The contrast–structure factor's mean.
double mean_structure(const MomentPlanes<double>& moments) {
  double sum = 0;
  for (size_t p = 0; p < moments.x.size(); ++p) {
    const SsimTerms<double> terms = ssim_terms(moments.moments(p));
    sum += terms.D / terms.B;
  }
  return sum / double(moments.x.size());
}

/// Π_j mean(structure_j)^β_j · mean(SSIM_5)^β_5  [Wang03, Eq. 7]; `finest`: moments of x and y.
double multi_scale(Plane x, Plane y, const MomentPlanes<double>& finest) {
  constexpr double kWeights[] = {.0448, .2856, .3001, .2363, .1333};
  constexpr size_t kScales = std::size(kWeights);
  double product = std::pow(std::max(0.0, mean_structure(finest)), kWeights[0]);
  for (size_t j = 1; j < kScales; ++j) {
    x = halved(x);
    y = halved(y);
    const MomentPlanes<double> moments = moments_of(x, y, Padding::kReflect, {});
    const double factor = j + 1 < kScales ? mean_structure(moments) : mean_ssim(moments, {});
    product *= std::pow(std::max(0.0, factor), kWeights[j]);
  }
  return product;
}

/// Everything that follows from the reflected moments of a channel.
StructureScores channel_scores(const Image8& a, const Image8& b, int channel,
                               Span<const uint8_t> mask) {
  const Plane x(a, channel), y(b, channel);
  const MomentPlanes<double> moments = moments_of(x, y, Padding::kReflect, mask);
  StructureScores scores;
  scores.reflect = mean_ssim(moments, mask);
  scores.inside = mean_inside(moments, a.width, a.height, 1, mask);
  scores.inside_range2 = mean_inside(moments, a.width, a.height, 2, mask);
  if (mask.empty() && std::min(a.width, a.height) >= kMultiScaleSide)
    scores.multi_scale = multi_scale(x, y, moments);
  return scores;
}

std::optional<double> mean_of(const StructureScores (&channels)[3],
                              std::optional<double> StructureScores::*member) {
  double sum = 0;
  for (const StructureScores& channel : channels) {
    if (!(channel.*member)) return std::nullopt;
    sum += *(channel.*member);
  }
  return sum / 3.0;
}

bool reflects(const Image8& image) {
  return image.width > kSsimRadius && image.height > kSsimRadius;
}

}  // namespace

std::optional<double> ssim(const Image8& a, const Image8& b, SsimPadding padding,
                           Span<const uint8_t> mask) {
  check_pair(a, b);
  const bool reflect = padding == SsimPadding::kReflect;
  if (reflect && !reflects(a)) return std::nullopt;
  double channel[3];
  parallel_for(3, 1, [&](int64_t c, int64_t) {
    channel[c] = mean_ssim(
        moments_of({a, int(c)}, {b, int(c)}, reflect ? Padding::kReflect : Padding::kZero, mask),
        mask);
  });
  return (channel[0] + channel[1] + channel[2]) / 3.0;
}

StructureScores structure_scores(const Image8& a, const Image8& b, Span<const uint8_t> mask) {
  check_pair(a, b);
  StructureScores scores, channels[3];
  if (reflects(a)) {
    parallel_for(3, 1,
                 [&](int64_t c, int64_t) { channels[c] = channel_scores(a, b, int(c), mask); });
    for (auto member : {&StructureScores::reflect, &StructureScores::inside,
                        &StructureScores::inside_range2, &StructureScores::multi_scale})
      scores.*member = mean_of(channels, member);
  }
  scores.zero = ssim(a, b, SsimPadding::kZero, mask);
  return scores;
}

}  // namespace tessera
