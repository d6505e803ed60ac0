// Known values of PSNR and SSIM, against sums written out here. Source: failure modes D1, D2, D3,
// B20.
#include "recon4d/evaluation/metrics.h"
#include "tests/support/random_image.h"

#include "kernels/math/photometric.h"
#include "recon4d/evaluation/mean_scores.h"
#include "tests/recon4d/model/small_models.h"

namespace tessera::testing {
namespace {

/// An image that looks like another: noise of a few steps.
Image8 disturbed(const Image8& image, uint64_t seed) {
  Random random(seed);
  Image8 other = image;
  for (uint8_t& byte : other.data)
    byte = uint8_t(std::clamp(int(byte) + random.below(61) - 30, 0, 255));
  return other;
}

/// SSIM by one two-dimensional sum per pixel, weights from the formula of a Gaussian.
double direct_ssim(const Image8& a, const Image8& b, bool reflect) {
  const auto sample = [&](const Image8& image, int x, int y, int c) {
    if (reflect) {
      x = x < 0 ? -x : x >= image.width ? 2 * image.width - 2 - x : x;
      y = y < 0 ? -y : y >= image.height ? 2 * image.height - 2 - y : y;
    }
    if (x < 0 || y < 0 || x >= image.width || y >= image.height) return 0.0;
    return image.data[size_t((y * image.width + x) * 3 + c)] / 255.0;
  };
  double weight[11][11], total = 0;
  for (int j = -5; j <= 5; ++j)
    for (int i = -5; i <= 5; ++i) total += std::exp(-(i * i + j * j) / (2 * 1.5 * 1.5));
  for (int j = -5; j <= 5; ++j)
    for (int i = -5; i <= 5; ++i)
      weight[j + 5][i + 5] = std::exp(-(i * i + j * j) / (2 * 1.5 * 1.5)) / total;
  double sum = 0;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < a.height; ++y)
      for (int x = 0; x < a.width; ++x) {
        double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
        for (int j = -5; j <= 5; ++j)
          for (int i = -5; i <= 5; ++i) {
            const double w = weight[j + 5][i + 5];
            const double p = sample(a, x + i, y + j, c), q = sample(b, x + i, y + j, c);
            ma += w * p;
            mb += w * q;
            aa += w * p * p;
            bb += w * q * q;
            ab += w * p * q;
          }
        const double va = aa - ma * ma, vb = bb - mb * mb, cov = ab - ma * mb;
        sum += (2 * ma * mb + 1e-4) * (2 * cov + 9e-4) /
               ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
      }
  return sum / (3.0 * a.width * a.height);
}

// Failure mode D1. Bug put back: 20·log10 in psnr_of_mse; seen to fail.
TEST(Metrics, PsnrOfAUniformOffsetOfTen) {
  Image8 a = random_image(31, 20, 1);
  for (uint8_t& byte : a.data) byte = uint8_t(byte % 240);
  Image8 b = a;
  for (uint8_t& byte : b.data) byte = uint8_t(byte + 10);
  EXPECT_NEAR(psnr(a, b), 28.1308, 5e-5);
  EXPECT_EQ(psnr(a, b), psnr(b, a));
  EXPECT_EQ(psnr(a, a), 100);
}

// Failure mode D1. Bug put back: zero padding used for both names; seen to fail.
TEST(Metrics, SsimEqualsTheDirectSum) {
  for (const auto& [width, height] : {std::pair{29, 17}, {6, 11}, {16, 40}}) {
    const Image8 a = random_image(width, height, 5), b = disturbed(a, 6);
    EXPECT_NEAR(ssim(a, b, SsimPadding::kReflect).value(), direct_ssim(a, b, true), 1e-6);
    EXPECT_NEAR(ssim(a, b, SsimPadding::kZero).value(), direct_ssim(a, b, false), 1e-6);
    EXPECT_GT(std::abs(direct_ssim(a, b, true) - direct_ssim(a, b, false)), 1e-4);
    EXPECT_NEAR(ssim(a, a, SsimPadding::kReflect).value(), 1, 1e-12);
  }
}

// Failure mode D2. Bug put back: psnr_of_mean_mse taken from the mean of PSNR; seen to fail.
TEST(Metrics, MeanOfPsnrIsNotPsnrOfTheMean) {
  std::vector<ViewScore> views(2);
  views[0].mse = 1e-2;
  views[1].mse = 1e-4;
  for (ViewScore& view : views) view.psnr = view.psnr_float = psnr_of_mse(view.mse);
  EXPECT_NEAR(views[0].psnr, 20, 1e-9);
  EXPECT_NEAR(views[1].psnr, 40, 1e-9);
  const MeanScore mean = mean_score(views);
  EXPECT_NEAR(mean.psnr.value(), 30.00, 1e-9);
  EXPECT_NEAR(mean.psnr_of_mean_mse.value(), 22.97, 5e-3);
  EXPECT_FALSE(mean.reflect.has_value());
}

// Failure mode D3. Bug put back: quantise by truncation; seen to fail.
TEST(Metrics, ScoresTheQuantisedImageAndTheFloatsApart) {
  const Image8 truth{8, 8, 3, std::vector<uint8_t>(192, 100)};
  std::vector<float> drawn(192, 100.4f / 255);
  const Span<const float> planar{drawn.data(), 192};
  EXPECT_EQ(psnr(quantise(planar, 8, 8), truth), 100);
  EXPECT_NEAR(psnr_float(planar, truth), 20 * std::log10(255 / 0.4), 1e-3);
  std::fill(drawn.begin(), drawn.end(), 100.6f / 255);
  EXPECT_NEAR(psnr(quantise(planar, 8, 8), truth), 20 * std::log10(255.0), 1e-9);
}

TEST(Metrics, QuantisesToTheNearestAndClamps) {
  const float nan = std::nanf("");
  const std::vector<float> planar = {-0.5f,        0.0f,  0.49f / 255,  0.5f / 255,
                                     254.4f / 255, 1.0f,  254.6f / 255, 7.0f,
                                     nan,          1e30f, -1e30f,       0.5f};
  const Image8 image = quantise({planar.data(), 12}, 2, 2);
  const std::vector<uint8_t> expected = {0, 254, 0, 0, 255, 255, 0, 255, 0, 1, 255, 128};
  EXPECT_EQ(image.data, expected);
}

// Failure mode B20. Bug put back: no size check before reflecting; seen to fail.
TEST(Metrics, TinyImagesHaveNoReflectedSsimAndNeverNan) {
  for (const auto& [width, height] : {std::pair{1, 1}, {5, 40}, {10, 10}, {15, 17}}) {
    const Image8 a = random_image(width, height, 8), b = random_image(width, height, 9);
    EXPECT_TRUE(std::isfinite(psnr(a, b)));
    const auto reflected = ssim(a, b, SsimPadding::kReflect);
    EXPECT_EQ(reflected.has_value(), width > 5 && height > 5);
    EXPECT_TRUE(std::isfinite(reflected.value_or(0)));
    EXPECT_TRUE(std::isfinite(ssim(a, b, SsimPadding::kZero).value()));
  }
}

// B17. Bugs put back, each seen to fail: the mean taken over all pixels; inverted polarity; ignored
// pixels counted; their truth read in the windows of others.
TEST(Metrics, IgnoredPixelsDoNotCount) {
  const Image8 a = random_image(20, 16, 10);
  Image8 b = a, garbage = a;
  std::vector<uint8_t> mask(320, 255);
  for (size_t p = 0; p < 320; ++p) {
    if (p % 20 < 10) mask[p] = 0;
    for (size_t c = 0; c < 3; ++c) {
      b.data[3 * p + c] = uint8_t(a.data[3 * p + c] ^ (mask[p] == 0 ? 0 : 1));
      garbage.data[3 * p + c] = uint8_t(b.data[3 * p + c] ^ (mask[p] == 0 ? 0x55 : 0));
    }
  }
  const Span<const uint8_t> used{mask.data(), 320};
  EXPECT_NEAR(psnr_of_mse(mean_squared_error(a, b, used)), 20 * std::log10(255.0), 1e-9);
  EXPECT_EQ(mean_squared_error(a, garbage, used), mean_squared_error(a, b, used));
  for (const SsimPadding padding : {SsimPadding::kReflect, SsimPadding::kZero}) {
    EXPECT_EQ(ssim(a, garbage, padding, used), ssim(a, b, padding, used));
    EXPECT_LT(ssim(a, b, padding, used).value(), 1);
  }
  const std::vector<uint8_t> all(320, 255);
  // with and without a mask the compiler may fuse sums in two ways
  EXPECT_NEAR(ssim(a, b, SsimPadding::kZero, {all.data(), 320}).value(),
              ssim(a, b, SsimPadding::kZero).value(), 1e-14);
}

}  // namespace
}  // namespace tessera::testing
