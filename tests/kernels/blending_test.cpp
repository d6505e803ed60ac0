// The function blend_backward by every field of a splat, against dual numbers through a plain
// blending loop. The splats are written by hand.
#include "kernels/cpu_backend.h"
#include "tests/support/dual.h"
#include "tests/support/random.h"

namespace tessera::testing {
namespace {

constexpr int kWidth = 21, kHeight = 19;  // four tiles, none full
constexpr int64_t kPixels = kWidth * kHeight;
constexpr double kBackground[3] = {0.3, 0.1, 0.6};
using SplatFields = std::array<double, 9>;  // mean2d 2, conic 3, opacity, colour 3

ViewBatch<double> one_view() {
  View view;
  view.camera.width = kWidth;
  view.camera.height = kHeight;
  return make_view_batch<double>({view});
}

/// Splats of 2 to 1/√`least_conic` pixels.
std::vector<SplatFields> random_splats(int count, double most_opacity, double least_conic,
                                       Random& random) {
  std::vector<SplatFields> splats;
  for (int i = 0; i < count; ++i) {
    const double a = random.uniform(least_conic, 0.2), c = random.uniform(least_conic, 0.2);
    splats.push_back({random.uniform(-2, 23), random.uniform(-2, 21), a,
                      random.uniform(-0.8, 0.8) * std::sqrt(a * c), c,
                      random.uniform(0.2, most_opacity), random.uniform(0, 1), random.uniform(0, 1),
                      random.uniform(0, 1)});
  }
  return splats;
}

Splats<double> as_splats(const std::vector<SplatFields>& fields, const ViewArgs<double>& view) {
  Splats<double> s;
  s.count = int64_t(fields.size());
  s.splat.resize(s.count);
  s.depth.resize(s.count);
  s.rect.resize(s.count);
  s.tiles.resize(s.count);
  for (int64_t i = 0; i < s.count; ++i) {
    const SplatFields& f = fields[size_t(i)];
    s.splat[i] = {Vec2<double>(f[0], f[1]),
                  {f[2], f[3], f[4]},
                  f[5],
                  Vec3<double>(f[6], f[7], f[8]),
                  cutoff_power(f[5]),
                  0,
                  0};
    s.depth[i] = double(i + 1);
    s.rect[i] = {0, 0, uint16_t(view.tiles_x), uint16_t(view.tiles_y)};
    s.tiles[i] = s.rect[i].area();
    s.instances += s.tiles[i];
  }
  return s;
}

/// Σ g·C over all pixels, blended in order without tiles.
template <class Real>
Real plain_loss(const std::vector<std::array<Real, 9>>& splats, const std::vector<double>& g) {
  Real loss = Real(0);
  for (int64_t p = 0; p < kPixels; ++p) {
    Real T = Real(1), colour[3] = {Real(0), Real(0), Real(0)};
    for (const auto& s : splats) {
      const Real alpha =
          s[5] * splat_falloff(Sym2<Real>{s[2], s[3], s[4]}, s[0] - Real(double(p % kWidth) + 0.5),
                               s[1] - Real(double(p / kWidth) + 0.5));
      if (alpha < Real(1.0 / 255)) continue;
      for (size_t c = 0; c < 3; ++c) colour[c] += T * alpha * s[6 + c];
      T *= Real(1) - alpha;
      if (T < Real(1e-4)) break;
    }
    for (size_t c = 0; c < 3; ++c)
      loss += (colour[c] + T * Real(kBackground[c])) * Real(g[c * size_t(kPixels) + size_t(p)]);
  }
  return loss;
}

std::vector<SplatGradient<double>> stage_gradient(const std::vector<SplatFields>& fields,
                                                  const std::vector<double>& g,
                                                  Span<double> lengths = {}) {
  CpuBackend<double> backend;
  const ViewBatch<double> batch = one_view();
  const Splats<double> splats = as_splats(fields, batch.views[0]);
  TileInstances<double> instances;
  Images<double> images;
  RenderOptions options;
  std::copy_n(kBackground, 3, options.background);
  backend.bin({&batch, &splats, options, true}, instances);
  const BlendArgs<double> blend{&batch, &splats, &instances, options, true};
  backend.blend(blend, images);
  std::vector<SplatMoments<double>> moments(fields.size());
  backend.blend_backward({blend, &images, {g.data(), int64_t(g.size())}, lengths},
                         {moments.data(), int64_t(moments.size())});
  std::vector<SplatGradient<double>> out;
  for (size_t s = 0; s < fields.size(); ++s) {
    const Splat<double>& splat = splats.splat[int64_t(s)];
    out.push_back(splat_gradient(splat.conic, splat.opacity, moments[s]));
  }
  return out;
}

/// Of each splat, Σ over pixels of ‖dL/d mean2d‖ of the light of that pixel alone.
std::vector<double> lengths_by_pixel(const std::vector<SplatFields>& fields,
                                     const std::vector<double>& g) {
  std::vector<double> lengths(fields.size(), 0.0);
  for (size_t p = 0; p < size_t(kPixels); ++p) {
    std::vector<double> alone(g.size(), 0.0);
    for (size_t c = 0; c < 3; ++c) alone[c * size_t(kPixels) + p] = g[c * size_t(kPixels) + p];
    const std::vector<SplatGradient<double>> d = stage_gradient(fields, alone);
    for (size_t s = 0; s < fields.size(); ++s)
      lengths[s] += std::hypot(d[s].mean2d[0], d[s].mean2d[1]);
  }
  return lengths;
}

// Bug put back: |f| left out, so that pixels of opposite signs cancel; seen to fail.
TEST(BlendBackward, LengthsAreThoseOfThePixelsGradients) {
  Random random(7);
  const std::vector<SplatFields> fields = random_splats(8, 0.9, 0.005, random);
  std::vector<double> g(size_t(3 * kPixels)), lengths(fields.size(), -1.0);
  for (double& x : g) x = random.uniform(-1, 1);
  stage_gradient(fields, g, {lengths.data(), int64_t(lengths.size())});
  const std::vector<double> expected = lengths_by_pixel(fields, g);
  const std::vector<SplatGradient<double>> whole = stage_gradient(fields, g);
  for (size_t s = 0; s < fields.size(); ++s) {
    EXPECT_NEAR(lengths[s] * fields[s][5], expected[s], 1e-11 * expected[s]);
    EXPECT_GT(expected[s], 1.5 * std::hypot(whole[s].mean2d[0], whole[s].mean2d[1]));
  }
}

void expect_duals(const std::vector<SplatFields>& fields, Random& random, double tolerance) {
  std::vector<double> g(size_t(3 * kPixels));
  for (double& x : g) x = random.uniform(-1, 1);
  const auto actual = stage_gradient(fields, g);
  for (size_t s = 0; s < fields.size(); ++s) {
    auto expected = dual_gradient(fields[s], [&](const std::array<Dual, 9>& p) {
      std::vector<std::array<Dual, 9>> all;
      for (const SplatFields& f : fields) {
        all.emplace_back();
        std::copy(f.begin(), f.end(), all.back().begin());
      }
      all[s] = p;
      return plain_loss(all, g);
    });
    expected[3] /= 2;  // symmetric convention
    const SplatGradient<double>& d = actual[s];
    expect_near_all(std::array{d.mean2d[0], d.mean2d[1], d.conic.xx, d.conic.xy, d.conic.yy,
                               d.opacity, d.colour[0], d.colour[1], d.colour[2]},
                    expected, tolerance, "mean2d, conic, opacity, colour");
  }
}

TEST(BlendBackward, EqualsDuals) {
  // Bug put back: R not reduced by the splat's own weight before dL/dα; seen to fail.
  Random random(1);
  for (int round = 0; round < 3; ++round)
    expect_duals(random_splats(8, 0.9, 0.005, random), random, 1e-12);
}

TEST(BlendBackward, EqualsDualsWhereTransmittanceStops) {
  // Bug put back: `index < used` left out; seen to fail.
  Random random(2);
  std::vector<SplatFields> fields = random_splats(12, 0.999, 0.001, random);
  // four nearly opaque veils over everything: T = 1e-4 is crossed inside the list of every pixel
  for (int i = 0; i < 4; ++i)
    fields.insert(fields.begin() + 2 * i, {10, 9, 1e-4, 0, 1e-4, 0.95, 0.1 * i, 0.5, 0.3});
  // R/(1−α) multiplies the rounding of R by up to 1000
  expect_duals(fields, random, 1e-11);
}

TEST(BlendBackward, FullyOpaqueSplatIsFinite) {
  // mean on a pixel centre and opacity 1: α = 1 there and 1 − α = 0
  std::vector<SplatFields> fields{{8.5, 8.5, 0.1, 0, 0.1, 1.0, 0.2, 0.4, 0.6},
                                  {8.5, 8.5, 0.1, 0, 0.1, 0.5, 0.9, 0.1, 0.3}};
  const auto d = stage_gradient(fields, std::vector<double>(size_t(3 * kPixels), 1.0));
  for (const SplatGradient<double>& g : d) {
    EXPECT_TRUE(std::isfinite(g.opacity));
    EXPECT_TRUE(std::isfinite(g.mean2d[0] + g.mean2d[1] + g.conic.xx + g.conic.xy + g.conic.yy));
  }
  EXPECT_GT(d[0].colour[0], 1.0);
}

}  // namespace
}  // namespace tessera::testing
