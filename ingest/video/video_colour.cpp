// Configures libswscale for accurate rounding and chroma interpolated at full resolution.
#include "ingest/video/video_colour.h"

extern "C" {
#include <libavutil/frame.h>
#include <libswscale/swscale.h>
}

#include <opencv2/core.hpp>

#include "ingest/video/display_light.h"
#include "ingest/video/frame_colour.h"
#include "ingest/video/video_file.h"

namespace tessera {
namespace {

cv::Mat plane(const AVFrame& planes, int index) {
  return {planes.height, planes.width, CV_8UC1, planes.data[index], size_t(planes.linesize[index])};
}

/// Calls `fill` with memory for the coded image, RGB, and turns what it wrote clockwise.
template <class Fill>
Image8 upright_image(const AVFrame& coded, int quarter_turns, const Fill& fill) {
  const bool lies = quarter_turns % 2 != 0;
  Image8 image{lies ? coded.height : coded.width, lies ? coded.width : coded.height, 3, {}};
  image.data.resize(size_t(image.width) * size_t(image.height) * 3);
  cv::Mat upright(image.height, image.width, CV_8UC3, image.data.data());
  if (quarter_turns == 0) {
    fill(upright);
    return image;
  }
  constexpr cv::RotateFlags kTurns[] = {cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180,
                                        cv::ROTATE_90_COUNTERCLOCKWISE};
  cv::Mat lying(coded.height, coded.width, CV_8UC3);
  fill(lying);
  cv::rotate(lying, upright, kTurns[quarter_turns - 1]);
  return image;
}

/// Planes G, B, R → RGB.
void interleave(const AVFrame& planes, cv::Mat& image) {
  const cv::Mat rgb[] = {plane(planes, 2), plane(planes, 0), plane(planes, 1)};
  cv::merge(rgb, 3, image);
}

/// 16-bit RGB → 8-bit sRGB.
void show(const AVFrame& signals, const FrameColour& colour, cv::Mat& image) {
  for (int y = 0; y < signals.height; ++y)
    srgb_of(colour,
            reinterpret_cast<const uint16_t*>(signals.data[0] + ptrdiff_t(y) * signals.linesize[0]),
            size_t(signals.width), image.ptr<uint8_t>(y));
}

/// Memory for pixels of this size and format; that of the frame before where it fits.
void prepare_pixels(LibavOwned<AVFrame>& pixels, int width, int height, AVPixelFormat format) {
  if (pixels != nullptr && pixels->width == width && pixels->height == height &&
      pixels->format == format)
    return;
  pixels = new_frame();
  pixels->width = width;
  pixels->height = height;
  pixels->format = format;
  if (av_frame_get_buffer(pixels.get(), 0) < 0) throw std::bad_alloc();
}

}  // namespace

FrameToRgb::FrameToRgb() = default;
FrameToRgb::~FrameToRgb() {
  sws_freeContext(context_);
}

Image8 FrameToRgb::convert(const AVFrame& frame, const ImageShape& shape) {
  constexpr int kFlags = SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP;
  constexpr int kUnity = 1 << 16;  // contrast and saturation, 16.16 fixed point
  const FrameColour colour = colour_of(frame);
  if (!colour_refusal(colour).empty()) return {};
  // swscale's SIMD writes planes of 8 bits, twice as fast as RGB24.
  const AVPixelFormat format = colour.is_srgb() ? AV_PIX_FMT_GBRP : AV_PIX_FMT_RGB48;
  const bool lies = shape.quarter_turns % 2 != 0;
  prepare_pixels(pixels_,
                 shape.width == 0 ? frame.width
                 : lies           ? shape.height
                                  : shape.width,
                 shape.width == 0 ? frame.height
                 : lies           ? shape.width
                                  : shape.height,
                 format);
  const bool same_size = pixels_->width == frame.width && pixels_->height == frame.height;
  context_ = sws_getCachedContext(context_, frame.width, frame.height, AVPixelFormat(frame.format),
                                  pixels_->width, pixels_->height, format,
                                  kFlags | (same_size ? SWS_BILINEAR : SWS_AREA), nullptr, nullptr,
                                  nullptr);
  if (context_ == nullptr) return {};
  // The result is negative where the format has no matrix; RGB has none, which is no failure.
  sws_setColorspaceDetails(context_, sws_getCoefficients(colour.matrix), colour.full_range,
                           sws_getCoefficients(SWS_CS_DEFAULT), 1, 0, kUnity, kUnity);
  const int lines = sws_scale(context_, frame.data, frame.linesize, 0, frame.height, pixels_->data,
                              pixels_->linesize);
  if (lines != pixels_->height) return {};
  return upright_image(*pixels_, shape.quarter_turns, [&](cv::Mat& image) {
    if (colour.is_srgb())
      interleave(*pixels_, image);
    else
      show(*pixels_, colour, image);
  });
}

}  // namespace tessera
