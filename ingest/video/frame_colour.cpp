// Reads the colour fields of libavutil. Their values are those of ITU-T H.273.
#include "ingest/video/frame_colour.h"

extern "C" {
#include <libavutil/frame.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

namespace tessera {
namespace {

constexpr int kHighDefinitionLines = 720;  // from here on, unstated colour is BT.709

int matrix_of(AVColorSpace stated, int height) {
  switch (stated) {
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
      return FrameColour::kNoMatrix;
    default:
      return height < kHighDefinitionLines ? SWS_CS_ITU601 : SWS_CS_ITU709;
  }
}

bool is_full_range(AVColorRange stated, int pixel_format) {
  if (stated != AVCOL_RANGE_UNSPECIFIED) return stated == AVCOL_RANGE_JPEG;
  switch (pixel_format) {
    case AV_PIX_FMT_YUVJ420P:
    case AV_PIX_FMT_YUVJ422P:
    case AV_PIX_FMT_YUVJ444P:
    case AV_PIX_FMT_YUVJ440P:
    case AV_PIX_FMT_YUVJ411P:
      return true;
    default:
      break;
  }
  const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(AVPixelFormat(pixel_format));
  const bool is_rgb_or_grey =
      (format->flags & AV_PIX_FMT_FLAG_RGB) != 0 || format->nb_components < 3;
  return is_rgb_or_grey;
}

TransferCurve transfer_of(AVColorTransferCharacteristic stated) {
  switch (stated) {
    case AVCOL_TRC_ARIB_STD_B67:
      return TransferCurve::kHlg;
    case AVCOL_TRC_SMPTE2084:
      return TransferCurve::kPq;
    default:
      return TransferCurve::kSdr;
  }
}

ColourPrimaries primaries_of(AVColorPrimaries stated, TransferCurve transfer) {
  const bool unstated = stated == AVCOL_PRI_UNSPECIFIED || stated == AVCOL_PRI_RESERVED0;
  if (unstated && transfer != TransferCurve::kSdr) return ColourPrimaries::kBt2020;
  return stated == AVCOL_PRI_BT2020 ? ColourPrimaries::kBt2020 : ColourPrimaries::kBt709;
}

/// FFmpeg 6.1 moved it from a field to a flag.
bool is_interlaced(const AVFrame& frame) {
#ifdef AV_FRAME_FLAG_INTERLACED
  return (frame.flags & AV_FRAME_FLAG_INTERLACED) != 0;
#else
  return frame.interlaced_frame != 0;
#endif
}

}  // namespace

FrameColour colour_of(const AVFrame& frame) {
  FrameColour colour;
  colour.matrix = matrix_of(frame.colorspace, frame.height);
  colour.full_range = is_full_range(frame.color_range, frame.format);
  colour.transfer = transfer_of(frame.color_trc);
  colour.primaries = primaries_of(frame.color_primaries, colour.transfer);
  colour.interlaced = is_interlaced(frame);
  return colour;
}

const char* tone_map_of(const FrameColour& colour) {
  switch (colour.transfer) {
    case TransferCurve::kHlg:
      return "hlg to srgb, 203 nits white";
    case TransferCurve::kPq:
      return "pq to srgb, 203 nits white";
    case TransferCurve::kSdr:
      break;
  }
  return colour.is_srgb() ? "none" : "bt2020 primaries to bt709";
}

}  // namespace tessera
