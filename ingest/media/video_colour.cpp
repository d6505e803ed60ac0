// What: swscale set up so that rounding is right: accurate, chroma interpolated at full resolution.
// Not: resizing; that happens in RGB by area (picture_scale.h).
#include "ingest/media/video_colour.h"

extern "C" {
#include <libavutil/frame.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include <memory>
#include <new>

namespace tessera {
namespace {

constexpr int kHighDefinitionLines = 720;  // from here on, unstated colour is BT.709

/// swscale's name of the YCbCr matrix.
int matrix_of(const AVFrame& frame) {
  switch (frame.colorspace) {
    case AVCOL_SPC_BT709:
      return SWS_CS_ITU709;
    case AVCOL_SPC_FCC:
      return SWS_CS_FCC;
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
      return SWS_CS_ITU601;
    case AVCOL_SPC_SMPTE240M:
      return SWS_CS_SMPTE240M;
    case AVCOL_SPC_BT2020_NCL:
    case AVCOL_SPC_BT2020_CL:
      return SWS_CS_BT2020;
    default:
      return frame.height < kHighDefinitionLines ? SWS_CS_ITU601 : SWS_CS_ITU709;
  }
}

bool is_full_range(const AVFrame& frame) {
  if (frame.color_range != AVCOL_RANGE_UNSPECIFIED) return frame.color_range == AVCOL_RANGE_JPEG;
  switch (frame.format) {
    case AV_PIX_FMT_YUVJ420P:
    case AV_PIX_FMT_YUVJ422P:
    case AV_PIX_FMT_YUVJ444P:
    case AV_PIX_FMT_YUVJ440P:
    case AV_PIX_FMT_YUVJ411P:
      return true;
    default:
      break;
  }
  const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(AVPixelFormat(frame.format));
  const bool is_rgb_or_grey =
      (format->flags & AV_PIX_FMT_FLAG_RGB) != 0 || format->nb_components < 3;
  return is_rgb_or_grey;
}

struct FrameRelease {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};

}  // namespace

FrameToRgb::FrameToRgb() = default;
FrameToRgb::~FrameToRgb() {
  sws_freeContext(context_);
}

Image8 FrameToRgb::convert(const AVFrame& frame) {
  constexpr int kFlags = SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP;
  constexpr int kUnity = 1 << 16;  // contrast and saturation, 16.16 fixed point
  const auto format = AVPixelFormat(frame.format);
  context_ =
      sws_getCachedContext(context_, frame.width, frame.height, format, frame.width, frame.height,
                           AV_PIX_FMT_RGB24, kFlags, nullptr, nullptr, nullptr);
  if (context_ == nullptr) return {};
  // The result says whether the format has a matrix at all; RGB has none, which is no failure.
  sws_setColorspaceDetails(context_, sws_getCoefficients(matrix_of(frame)), is_full_range(frame),
                           sws_getCoefficients(SWS_CS_DEFAULT), 1, 0, kUnity, kUnity);
  const std::unique_ptr<AVFrame, FrameRelease> rgb(av_frame_alloc());
  if (rgb == nullptr) throw std::bad_alloc();
  rgb->width = frame.width, rgb->height = frame.height, rgb->format = AV_PIX_FMT_RGB24;
  if (av_frame_get_buffer(rgb.get(), 0) < 0) throw std::bad_alloc();
  const int lines =
      sws_scale(context_, frame.data, frame.linesize, 0, frame.height, rgb->data, rgb->linesize);
  if (lines != frame.height) return {};
  Image8 image{frame.width, frame.height, 3, {}};
  const auto stride = size_t(frame.width) * 3;
  image.data.reserve(stride * size_t(frame.height));
  for (int y = 0; y < frame.height; ++y) {
    const uint8_t* row = rgb->data[0] + ptrdiff_t(y) * rgb->linesize[0];
    image.data.insert(image.data.end(), row, row + stride);
  }
  return image;
}

}  // namespace tessera
