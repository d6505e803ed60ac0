// Reads the colour fields of libavutil. Their values are those of ITU-T H.273.
#include "ingest/video/frame_colour.h"

extern "C" {
#include <libavcodec/codec_par.h>
#include <libavutil/frame.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include <fmt/format.h>

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
  const bool is_rgb_or_grey = format != nullptr && ((format->flags & AV_PIX_FMT_FLAG_RGB) != 0 ||
                                                    format->nb_components < 3);
  return is_rgb_or_grey;
}

TransferCurve transfer_of(AVColorTransferCharacteristic stated) {
  switch (stated) {
    case AVCOL_TRC_ARIB_STD_B67:
      return TransferCurve::kHlg;
    case AVCOL_TRC_SMPTE2084:
      return TransferCurve::kPq;
    case AVCOL_TRC_LINEAR:
    case AVCOL_TRC_LOG:
    case AVCOL_TRC_LOG_SQRT:
    case AVCOL_TRC_SMPTE428:
      return TransferCurve::kNone;
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

/// What a frame and a track state alike.
struct StatedColour {
  AVColorSpace matrix;
  AVColorRange range;
  AVColorTransferCharacteristic transfer;
  AVColorPrimaries primaries;
  int height, pixel_format;
};

FrameColour colour_as_stated(const StatedColour& stated, bool interlaced) {
  FrameColour colour;
  colour.matrix = matrix_of(stated.matrix, stated.height);
  colour.full_range = is_full_range(stated.range, stated.pixel_format);
  colour.transfer = transfer_of(stated.transfer);
  colour.primaries = primaries_of(stated.primaries, colour.transfer);
  colour.interlaced = interlaced;
  if (const char* name = av_color_transfer_name(stated.transfer)) colour.transfer_name = name;
  if (const char* name = av_color_space_name(stated.matrix)) colour.matrix_name = name;
  return colour;
}

}  // namespace

FrameColour colour_of(const AVFrame& frame) {
  return colour_as_stated({frame.colorspace, frame.color_range, frame.color_trc,
                           frame.color_primaries, frame.height, frame.format},
                          is_interlaced(frame));
}

FrameColour colour_of(const AVCodecParameters& track) {
  const bool progressive =
      track.field_order == AV_FIELD_UNKNOWN || track.field_order == AV_FIELD_PROGRESSIVE;
  return colour_as_stated({track.color_space, track.color_range, track.color_trc,
                           track.color_primaries, track.height, track.format},
                          !progressive);
}

std::string colour_refusal(const FrameColour& colour) {
  if (colour.matrix != FrameColour::kNoMatrix && colour.transfer != TransferCurve::kNone) return "";
  return fmt::format(
      "its colours (matrix {}, transfer curve {}) have no conversion to sRGB here; convert them "
      "with `ffmpeg -i IN -vf zscale=matrix=bt709:transfer=bt709:primaries=bt709:range=limited,"
      "format=yuv420p -crf 12 OUT`, or export the video as SDR in BT.709",
      colour.matrix_name, colour.transfer_name);
}

std::string colour_name(const FrameColour& colour) {
  const bool wide = colour.primaries == ColourPrimaries::kBt2020;
  switch (colour.transfer) {
    case TransferCurve::kHlg:
      return wide ? "HLG" : "HLG in BT.709";
    case TransferCurve::kPq:
      return wide ? "PQ" : "PQ in BT.709";
    case TransferCurve::kSdr:
    case TransferCurve::kNone:
      break;
  }
  return wide ? "SDR in BT.2020" : "SDR";
}

const char* tone_map_of(const FrameColour& colour) {
  switch (colour.transfer) {
    case TransferCurve::kHlg:
      return "hlg to srgb, 203 nits white";
    case TransferCurve::kPq:
      return "pq to srgb, 203 nits white";
    case TransferCurve::kSdr:
    case TransferCurve::kNone:
      break;
  }
  return colour.is_srgb() ? "none" : "bt2020 primaries to bt709";
}

}  // namespace tessera
