// SSIM at one pixel, its partial derivatives, the window, and the photometric stage against a loop
// written from the definition.
#include "kernels/math/photometric.h"

#include "kernels/cpu_backend.h"
#include "tests/support/dual.h"
#include "tests/support/random.h"

namespace tessera::testing {
namespace {

TEST(Ssim, PartialsEqualDuals) {
  Random random(1);
  for (int round = 0; round < 50; ++round) {
    const double x = random.uniform(0, 1), y = random.uniform(0, 1);
    const double vx = random.uniform(0.001, 0.1), vy = random.uniform(0.001, 0.1);
    const double cov = random.uniform(-1, 1) * std::sqrt(vx * vy);
    const std::array<double, 3> moments{x, x * x + vx, x * y + cov};
    const auto expected = dual_gradient(moments, [&](const auto& p) {
      return ssim_point(SsimMoments<Dual>{p[0], y, p[1] + y * y + vy, p[2]}).value;
    });
    const SsimPoint<double> point =
        ssim_point(SsimMoments<double>{x, y, moments[1] + y * y + vy, moments[2]});
    expect_near_all(std::array{point.d_x, point.d_xx, point.d_xy}, expected, 1e-12, "partials");
    const double by_hand =
        (2 * x * y + 1e-4) * (2 * cov + 9e-4) / ((x * x + y * y + 1e-4) * (vx + vy + 9e-4));
    EXPECT_NEAR(point.value, by_hand, 1e-12);
  }
}

TEST(Ssim, WindowIsANormalisedGaussianOfSigmaOneAndAHalf) {
  double sum = 0;
  for (int k = -kSsimRadius; k <= kSsimRadius; ++k) sum += std::exp(-k * k / (2 * 1.5 * 1.5));
  for (int k = -kSsimRadius; k <= kSsimRadius; ++k)
    EXPECT_NEAR(kSsimWindow<double>[k + kSsimRadius], std::exp(-k * k / (2 * 1.5 * 1.5)) / sum,
                1e-12);
}

/// Two images with one view each, as the photometric stage takes them.
struct LossCase {
  ViewBatch<double> batch;
  Images<double> images;
  std::vector<std::vector<uint8_t>> truth, mask;  // mask: none, or of every view
  LossWeights weights;

  LossCase(std::initializer_list<std::pair<int, int>> sizes, Random& random) {
    std::vector<View> views;
    for (const auto& [width, height] : sizes) {
      View view;
      view.camera.width = width;
      view.camera.height = height;
      views.push_back(view);
      truth.emplace_back(size_t(3 * width * height));
      for (uint8_t& byte : truth.back()) byte = uint8_t(random.below(256));
    }
    batch = make_view_batch<double>(views);
    images.colour.resize(3 * batch.pixels);
    for (double& x : images.colour) x = random.uniform(-0.1, 1.1);
  }

  std::vector<ViewLoss> loss(Span<double> d_colour) {
    PhotometricArgs<double> args{&batch, images.colour.span(), {}, weights, {}};
    for (const auto& bytes : truth) args.truth.emplace_back(bytes.data(), int64_t(bytes.size()));
    for (const auto& bytes : mask) args.mask.emplace_back(bytes.data(), int64_t(bytes.size()));
    CpuBackend<double> backend;
    backend.photometric(args, d_colour);
    return backend.outcome().losses;
  }
};

/// Windowed mean of f over pixels around (px, py), zero outside the image, not separable.
template <class Function>
double windowed(int px, int py, int width, int height, Function&& f) {
  double sum = 0;
  for (int y = std::max(0, py - 5); y <= std::min(height - 1, py + 5); ++y)
    for (int x = std::max(0, px - 5); x <= std::min(width - 1, px + 5); ++x)
      sum += kSsimWindow<double>[x - px + 5] * kSsimWindow<double>[y - py + 5] * f(x, y);
  return sum;
}

double ssim_by_definition(const double* a, const uint8_t* rgb, int width, int height) {
  const auto A = [&](int x, int y) { return a[y * width + x]; };
  const auto B = [&](int x, int y) { return rgb[3 * (y * width + x)] / 255.0; };
  double sum = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto w = [&](auto f) { return windowed(x, y, width, height, f); };
      const double ma = w(A), mb = w(B);
      const double va = w([&](int u, int v) { return A(u, v) * A(u, v); }) - ma * ma;
      const double vb = w([&](int u, int v) { return B(u, v) * B(u, v); }) - mb * mb;
      const double cov = w([&](int u, int v) { return A(u, v) * B(u, v); }) - ma * mb;
      sum +=
          (2 * ma * mb + 1e-4) * (2 * cov + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
    }
  return sum / (width * height);
}

TEST(Photometric, LossEqualsItsDefinition) {
  Random random(2);
  LossCase p({{13, 17}, {5, 3}, {1, 1}}, random);
  const auto losses = p.loss({});
  for (size_t b = 0; b < 3; ++b) {
    const ViewArgs<double>& view = p.batch.views[b];
    const int pixels = view.width * view.height;
    double l1 = 0, ssim = 0;
    for (int c = 0; c < 3; ++c) {
      const double* plane = p.images.colour.data() + 3 * view.first_pixel + c * pixels;
      for (int i = 0; i < pixels; ++i)
        l1 += std::abs(plane[i] - p.truth[b][size_t(3 * i + c)] / 255.0) / (3 * pixels);
      ssim += ssim_by_definition(plane, p.truth[b].data() + c, view.width, view.height) / 3;
    }
    EXPECT_NEAR(losses[b].l1, l1, 1e-12);
    EXPECT_NEAR(losses[b].ssim, ssim, 1e-12);
    EXPECT_NEAR(losses[b].total, 0.8 * l1 + 0.2 * (1 - ssim), 1e-12);
  }
}

TEST(Photometric, GradientIsThatOfTheMeanOverTheBatch) {
  // Bug put back: the partial by E[xy] not convolved; seen to fail.
  Random random(3);
  LossCase p({{13, 17}, {7, 4}}, random);
  std::vector<double> d_colour(size_t(3 * p.batch.pixels));
  p.loss({d_colour.data(), int64_t(d_colour.size())});
  constexpr double kStep = 1e-5;
  for (int64_t i = 0; i < 3 * p.batch.pixels; i += 7) {
    const double x = p.images.colour[i];
    const auto loss = [&](double value) {
      p.images.colour[i] = value;
      const auto losses = p.loss({});
      return (losses[0].total + losses[1].total) / 2;
    };
    const double difference = (loss(x + kStep) - loss(x - kStep)) / (2 * kStep);
    p.images.colour[i] = x;
    EXPECT_NEAR(d_colour[size_t(i)], difference, 1e-9) << i;  // gradients are of order 1e-3
  }
}

/// A mask of noise: about half of the pixels are ignored.
std::vector<uint8_t> speckled(int pixels, Random& random) {
  std::vector<uint8_t> mask(static_cast<size_t>(pixels));
  for (uint8_t& used : mask) used = random.below(2) == 1 ? 255 : 0;
  return mask;
}

// B17. By the definition: the truth at ignored pixels is the image, SSIM there is 1.
// Bugs put back, each seen to fail: inverted polarity; the ignored pixels' own windows counted;
// their truth read in the windows of others; the mask of the next view.
TEST(Photometric, LossWithAMaskEqualsItsDefinition) {
  Random random(4);
  LossCase p({{13, 17}, {6, 5}}, random);
  p.mask = {speckled(13 * 17, random), {}};  // the second view has none
  const auto losses = p.loss({});
  for (size_t b = 0; b < 2; ++b) {
    const ViewArgs<double>& view = p.batch.views[b];
    const int width = view.width, pixels = width * view.height;
    double l1 = 0, ssim = 0;
    for (int c = 0; c < 3; ++c) {
      const double* x = p.images.colour.data() + 3 * view.first_pixel + c * pixels;
      const auto used = [&](int i) { return p.mask[b].empty() || p.mask[b][size_t(i)] != 0; };
      const auto A = [&](int u, int v) { return x[v * width + u]; };
      const auto B = [&](int u, int v) {
        const int i = v * width + u;
        return used(i) ? p.truth[b][size_t(3 * i + c)] / 255.0 : x[i];
      };
      for (int i = 0; i < pixels; ++i) {
        l1 += std::abs(x[i] - B(i % width, i / width)) / (3 * pixels);
        const auto w = [&](auto f) {
          return windowed(i % width, i / width, width, view.height, f);
        };
        const double ma = w(A), mb = w(B);
        const double va = w([&](int u, int v) { return A(u, v) * A(u, v); }) - ma * ma;
        const double vb = w([&](int u, int v) { return B(u, v) * B(u, v); }) - mb * mb;
        const double cov = w([&](int u, int v) { return A(u, v) * B(u, v); }) - ma * mb;
        const double value = (2 * ma * mb + 1e-4) * (2 * cov + 9e-4) /
                             ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
        ssim += (used(i) ? value : 1) / (3 * pixels);
      }
    }
    EXPECT_NEAR(losses[b].l1, l1, 1e-12);
    EXPECT_NEAR(losses[b].ssim, ssim, 1e-12);
  }
}

// B17. Bugs put back, each seen to fail: maps of ignored pixels not zeroed; the gradient of ignored
// pixels left as the windows of their neighbours give it.
TEST(Photometric, GradientWithAMaskIsThatOfUsedPixelsAndZeroElsewhere) {
  Random random(5);
  LossCase p({{13, 17}, {7, 4}}, random);
  p.mask = {speckled(13 * 17, random), speckled(7 * 4, random)};
  std::vector<double> d_colour(size_t(3 * p.batch.pixels));
  p.loss({d_colour.data(), int64_t(d_colour.size())});
  constexpr double kStep = 1e-5;
  for (size_t b = 0; b < 2; ++b) {
    const ViewArgs<double>& view = p.batch.views[b];
    const int64_t pixels = int64_t(view.width) * view.height;
    for (int64_t i = 0; i < 3 * pixels; ++i) {
      double& x = p.images.colour.data()[3 * view.first_pixel + i];
      const double d = d_colour[size_t(3 * view.first_pixel + i)], kept = x;
      if (p.mask[b][size_t(i % pixels)] == 0) {
        EXPECT_EQ(d, 0.0) << i;
        continue;
      }
      const auto loss = [&](double value) {
        x = value;
        const auto losses = p.loss({});
        return (losses[0].total + losses[1].total) / 2;
      };
      const double difference = (loss(kept + kStep) - loss(kept - kStep)) / (2 * kStep);
      x = kept;
      EXPECT_NEAR(d, difference, 1e-9) << i;  // gradients are of order 1e-3
    }
  }
}

}  // namespace
}  // namespace tessera::testing
