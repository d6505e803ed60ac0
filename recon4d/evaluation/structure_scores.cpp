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

/// Sums over used pixels of one channel.
struct StructureSums {
  double ssim = 0, structure = 0;  // luminance · structure; the contrast–structure factor
  /// Of the pixels whose window lies inside the image: SSIM at range 1 and 2.
  double inside = 0, inside_range2 = 0;
  int64_t inside_pixels = 0;
};

double ssim_of(const SsimTerms<double>& terms) {
  return terms.C * terms.D / (terms.A * terms.B);
}

/// Not inlined: no digit of it depends on what else is computed beside it.
[[gnu::noinline]] void add_ssim(const SsimMoments<double>& moments, bool, StructureSums& sums) {
  sums.ssim += ssim_of(ssim_terms(moments));
}

void add_all(const SsimMoments<double>& moments, bool is_inside, StructureSums& sums) {
  add_ssim(moments, is_inside, sums);
  const SsimTerms<double> terms = ssim_terms(moments);
  sums.structure += terms.D / terms.B;
  if (!is_inside) return;
  sums.inside += ssim_of(terms);
  sums.inside_range2 += ssim_of(ssim_terms(moments, 4 * kSsimC1<double>, 4 * kSsimC2<double>));
  ++sums.inside_pixels;
}

/// Of the pixels that `used(y, x)` tells; read(y, a, b) writes row y of both planes.
template <class Read, class Used, class Add>
StructureSums sums_of(int width, int height, Padding padding, const Read& read, const Used& used,
                      const Add& add) {
  StructureSums sums;
  MomentRows<double>(width, height, padding).compute(read, [&](int y, const auto& moments) {
    const bool inside = y >= kSsimRadius && y < height - kSsimRadius;
    for (int x = 0; x < width; ++x)
      if (used(y, x)) add(moments(x), inside && x >= kSsimRadius && x < width - kSsimRadius, sums);
  });
  return sums;
}

/// One channel of two images in values of [0, 1]; b is a where the mask ignores.
struct ChannelPair {
  const Image8 &a, &b;
  int channel;
  Span<const uint8_t> mask;

  bool used(int y, int x) const { return is_used(mask, size_t(y) * size_t(a.width) + size_t(x)); }
  /// Writes columns [left, right) of row y.
  void read(int y, int left, int right, double* to_a, double* to_b) const {
    const auto value = [&](const Image8& image, int x) {
      return image.data[3 * (size_t(y) * size_t(image.width) + size_t(x)) + size_t(channel)] /
             255.0;
    };
    for (int x = left; x < right; ++x) {
      to_a[x - left] = value(a, x);
      to_b[x - left] = used(y, x) ? value(b, x) : value(a, x);
    }
  }
};

template <class Add>
StructureSums sums_of(const ChannelPair& pair, Padding padding, const Add& add) {
  const int width = pair.a.width;
  return sums_of(
      width, pair.a.height, padding,
      [&](int y, double* to_a, double* to_b) { pair.read(y, 0, width, to_a, to_b); },
      [&](int y, int x) { return pair.used(y, x); }, add);
}

/// Σ SSIM with zeros outside, over the used pixels whose window reaches outside. Images
/// that reflection needs.
double border_sum(const ChannelPair& pair) {
  constexpr int r = kSsimRadius;
  const int width = pair.a.width, height = pair.a.height;
  const struct {
    int top, bottom, left, right;
  } sides[] = {{0, r, 0, width},
               {std::max(r, height - r), height, 0, width},
               {r, height - r, 0, r},
               {r, height - r, std::max(r, width - r), width}};
  double sum = 0;
  for (const auto& side : sides) {
    // zeros beyond what is read are seen from this side alone where the images end
    const int top = std::max(0, side.top - r), left = std::max(0, side.left - r);
    const int right = std::min(width, side.right + r);
    sum +=
        sums_of(
            right - left, std::min(height, side.bottom + r) - top, Padding::kZero,
            [&](int y, double* to_a, double* to_b) { pair.read(top + y, left, right, to_a, to_b); },
            [&](int y, int x) {
              return top + y >= side.top && top + y < side.bottom && left + x >= side.left &&
                     left + x < side.right && pair.used(top + y, left + x);
            },
            add_ssim)
            .ssim;
  }
  return sum;
}

StructureSums sums_of(const Plane& a, const Plane& b) {
  const auto read = [&](int y, double* to_a, double* to_b) {
    const int64_t first = int64_t(y) * a.width;
    std::copy_n(a.value.data() + first, a.width, to_a);
    std::copy_n(b.value.data() + first, a.width, to_b);
  };
  return sums_of(
      a.width, a.height, Padding::kReflect, read, [](int, int) { return true; }, add_all);
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

/// Π_j mean(structure_j)^β_j · mean(SSIM_5)^β_5  [Wang03, Eq. 7]; `finest`: sums over x and y.
double multi_scale(Plane x, Plane y, const StructureSums& finest) {
  constexpr double kWeights[] = {.0448, .2856, .3001, .2363, .1333};
  constexpr size_t kScales = std::size(kWeights);
  double product = std::pow(std::max(0.0, finest.structure / double(x.value.size())), kWeights[0]);
  for (size_t j = 1; j < kScales; ++j) {
    x = halved(x);
    y = halved(y);
    const StructureSums sums = sums_of(x, y);
    const double sum = j + 1 < kScales ? sums.structure : sums.ssim;
    product *= std::pow(std::max(0.0, sum / double(x.value.size())), kWeights[j]);
  }
  return product;
}

/// Windows inside the image are the same for both borders, so that zeros cost the border alone.
StructureScores channel_scores(const ChannelPair& pair) {
  const auto count = double(used_pixels(pair.mask, pair.a.data.size() / 3));
  const StructureSums sums = sums_of(pair, Padding::kReflect, add_all);
  StructureScores scores;
  scores.reflect = sums.ssim / count;
  scores.zero = (sums.inside + border_sum(pair)) / count;
  if (sums.inside_pixels > 0) {
    scores.inside = sums.inside / double(sums.inside_pixels);
    scores.inside_range2 = sums.inside_range2 / double(sums.inside_pixels);
  }
  if (pair.mask.empty() && std::min(pair.a.width, pair.a.height) >= kMultiScaleSide)
    scores.multi_scale = multi_scale({pair.a, pair.channel}, {pair.b, pair.channel}, sums);
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
  const Padding border = reflect ? Padding::kReflect : Padding::kZero;
  double channel[3];
  parallel_for(3, 1, [&](int64_t c, int64_t) {
    channel[c] = sums_of(ChannelPair{a, b, int(c), mask}, border, add_ssim).ssim /
                 double(used_pixels(mask, a.data.size() / 3));
  });
  return (channel[0] + channel[1] + channel[2]) / 3.0;
}

StructureScores structure_scores(const Image8& a, const Image8& b, Span<const uint8_t> mask) {
  check_pair(a, b);
  StructureScores scores, channels[3];
  if (!reflects(a)) {
    scores.zero = ssim(a, b, SsimPadding::kZero, mask);
    return scores;
  }
  parallel_for(3, 1, [&](int64_t c, int64_t) {
    channels[c] = channel_scores({a, b, int(c), mask});
  });
  for (auto member : {&StructureScores::reflect, &StructureScores::zero, &StructureScores::inside,
                      &StructureScores::inside_range2, &StructureScores::multi_scale})
    scores.*member = mean_of(channels, member);
  return scores;
}

}  // namespace tessera
