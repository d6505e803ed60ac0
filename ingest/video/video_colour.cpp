// Configures libswscale for accurate rounding and chroma interpolated at full resolution.
#include "ingest/video/video_colour.h"

extern "C" {
#include <libavutil/frame.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include <opencv2/core.hpp>

#include "ingest/video/video_file.h"

namespace tessera {
namespace {

constexpr int kHighDefinitionLines = 720;  // from here on, unstated colour is BT.709

constexpr int kNoMatrix = -1;

/// swscale's name of the YCbCr matrix; kNoMatrix where it has none.
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
      return SWS_CS_BT2020;
    case AVCOL_SPC_BT2020_CL:
    case AVCOL_SPC_YCGCO:
    case AVCOL_SPC_SMPTE2085:
    case AVCOL_SPC_CHROMA_DERIVED_CL:
    case AVCOL_SPC_ICTCP:
      return kNoMatrix;
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

cv::Mat plane(const AVFrame& planes, int index) {
  return {planes.height, planes.width, CV_8UC1, planes.data[index], size_t(planes.linesize[index])};
}

/// Planes G, B, R → RGB, turned clockwise.
Image8 interleaved(const AVFrame& planes, int quarter_turns) {
  const bool lies = quarter_turns % 2 != 0;
  Image8 image{lies ? planes.height : planes.width, lies ? planes.width : planes.height, 3, {}};
  image.data.resize(size_t(image.width) * size_t(image.height) * 3);
  cv::Mat upright(image.height, image.width, CV_8UC3, image.data.data());
  const cv::Mat rgb[] = {plane(planes, 2), plane(planes, 0), plane(planes, 1)};
  if (quarter_turns == 0) {
    cv::merge(rgb, 3, upright);
    return image;
  }
  constexpr cv::RotateFlags kTurns[] = {cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180,
                                        cv::ROTATE_90_COUNTERCLOCKWISE};
  cv::Mat coded;
  cv::merge(rgb, 3, coded);
  cv::rotate(coded, upright, kTurns[quarter_turns - 1]);
  return image;
}

/// Memory for planes of this size; that of the frame before where it fits.
void prepare_planes(LibavOwned<AVFrame>& planes, int width, int height) {
  if (planes != nullptr && planes->width == width && planes->height == height) return;
  planes = new_frame();
  planes->width = width;
  planes->height = height;
  planes->format = AV_PIX_FMT_GBRP;  // swscale's SIMD writes planes, twice as fast as RGB24
  if (av_frame_get_buffer(planes.get(), 0) < 0) throw std::bad_alloc();
}

}  // namespace

FrameToRgb::FrameToRgb() = default;
FrameToRgb::~FrameToRgb() {
  sws_freeContext(context_);
}

Image8 FrameToRgb::convert(const AVFrame& frame, const ImageShape& shape) {
  constexpr int kFlags = SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP;
  constexpr int kUnity = 1 << 16;  // contrast and saturation, 16.16 fixed point
  const int matrix = matrix_of(frame);
  if (matrix == kNoMatrix) return {};
  const bool lies = shape.quarter_turns % 2 != 0;
  prepare_planes(planes_,
                 shape.width == 0 ? frame.width
                 : lies           ? shape.height
                                  : shape.width,
                 shape.width == 0 ? frame.height
                 : lies           ? shape.width
                                  : shape.height);
  const bool same_size = planes_->width == frame.width && planes_->height == frame.height;
  context_ = sws_getCachedContext(context_, frame.width, frame.height, AVPixelFormat(frame.format),
                                  planes_->width, planes_->height, AV_PIX_FMT_GBRP,
                                  kFlags | (same_size ? SWS_BILINEAR : SWS_AREA), nullptr, nullptr,
                                  nullptr);
  if (context_ == nullptr) return {};
  // The result is negative where the format has no matrix; RGB has none, which is no failure.
  sws_setColorspaceDetails(context_, sws_getCoefficients(matrix), is_full_range(frame),
                           sws_getCoefficients(SWS_CS_DEFAULT), 1, 0, kUnity, kUnity);
  const int lines = sws_scale(context_, frame.data, frame.linesize, 0, frame.height, planes_->data,
                              planes_->linesize);
  if (lines != planes_->height) return {};
  return interleaved(*planes_, shape.quarter_turns);
}

}  // namespace tessera
