// PSNR of 8-bit images and of floats. With a mask of [height, width] (0: ignored; empty: none)
// means are over the used pixels, of which there is at least one. Source: method A.15; failure
// modes D1–D3, B20.
#pragma once
#include "ingest/scene.h"
#include "kernels/base/buffer.h"

namespace tessera {

/// 8-bit image of planar [3, height, width] floats: floor(255·x + 0.5), clamped.
Image8 quantise(Span<const float> planar_rgb, int width, int height);

/// Mean of the squared differences over 3·H·W at range 1; both images RGB and of one size.
double mean_squared_error(const Image8& a, const Image8& b, Span<const uint8_t> mask = {});
/// 10·log10(1/mse); infinite for equal images is capped at 100.
double psnr_of_mse(double mse);
/// Of 8-bit images.
double psnr(const Image8& a, const Image8& b);
/// Of floats against 8-bit truth, un-quantised and clamped to [0, 1]; NaN counts as 0.
double psnr_float(Span<const float> planar_rgb, const Image8& truth, Span<const uint8_t> mask = {});

/// The condition of all metrics on two images. Errors: std::logic_error.
void check_pair(const Image8& a, const Image8& b);
/// The mask of a frame, [height, width]; empty: it has none.
inline Span<const uint8_t> used_mask(const Frame& frame) {
  return {frame.mask.data().data(), int64_t(frame.mask.data().size())};
}
inline bool is_used(Span<const uint8_t> mask, size_t pixel) {
  return mask.empty() || mask[int64_t(pixel)] != 0;
}
/// Of an image of `pixels`, at least one.
size_t used_pixels(Span<const uint8_t> mask, size_t pixels);

}  // namespace tessera
