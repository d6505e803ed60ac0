// What: PSNR and SSIM of 8-bit pictures, each under its protocol's name. With a mask of
//       [height, width] (0: ignored; empty: none) means are over the used pixels, at least one.
// Not: a mean over views (evaluate.h), and no LPIPS in this version.
// Source: method A.15; failure modes D1–D3, B20.
#pragma once
#include <optional>

#include "ingest/scene.h"
#include "kernels/base/span.h"

namespace tessera {

/// 8-bit picture of planar [3, height, width] floats: floor(255·x + 0.5), clamped.
Image8 quantise(Span<const float> planar_rgb, int width, int height);

/// Mean of the squared differences over 3·H·W at range 1; both pictures RGB and of one size.
double mean_squared_error(const Image8& a, const Image8& b, Span<const uint8_t> mask = {});
/// 10·log10(1/mse); infinite for equal pictures is capped at 100.
double psnr_of_mse(double mse);
/// Of 8-bit pictures.
double psnr(const Image8& a, const Image8& b);
/// Of floats against 8-bit truth, un-quantised and clamped to [0, 1]; NaN counts as 0.
double psnr_float(Span<const float> planar_rgb, const Image8& truth, Span<const uint8_t> mask = {});

enum class SsimPadding { kReflect, kZero };
/// Mean over the full map and channels, 11 taps, σ 1.5, range 1. Nothing where the window does not
/// fit: reflection needs more than 5 pixels each way. In the windows of used pixels b is a where
/// the mask ignores, so that nothing is compared there.
std::optional<double> ssim(const Image8& a, const Image8& b, SsimPadding padding,
                           Span<const uint8_t> mask = {});

}  // namespace tessera
