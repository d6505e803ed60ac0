// What a video states about the colours and fields of its frames: matrix, range, transfer curve,
// primaries and interlacing, as far as the conversion to sRGB depends on them.
#pragma once

struct AVFrame;

namespace tessera {

/// How code values stand for light. ITU-R BT.2100 (HLG, PQ).
enum class TransferCurve {
  kSdr,  // BT.709, BT.601, sRGB, BT.2020 and what is unstated; values are taken as sRGB
  kHlg,  // ARIB STD-B67
  kPq    // SMPTE ST 2084
};

enum class ColourPrimaries {
  kBt709,  // also SMPTE 170M, BT.470BG and whatever else differs little from BT.709, and unstated
  kBt2020  // of HLG and PQ where none are stated
};

struct FrameColour {
  int matrix = 0;           // swscale's SWS_CS_…; kNoMatrix where it has no conversion to RGB
  bool full_range = false;  // black and white are the least and the greatest code
  TransferCurve transfer = TransferCurve::kSdr;
  ColourPrimaries primaries = ColourPrimaries::kBt709;
  bool interlaced = false;  // the lines of two times alternate

  static constexpr int kNoMatrix = -1;
  /// Its values are sRGB with BT.709 primaries as they are.
  bool is_srgb() const {
    return transfer == TransferCurve::kSdr && primaries == ColourPrimaries::kBt709;
  }
};

/// Unstated matrices are BT.601 below 720 lines, BT.709 from there; unstated ranges are limited but
/// of RGB, grey and the full-range formats.
FrameColour colour_of(const AVFrame& frame);

/// What is done to frames of this colour, as a prepared scene records it: "hlg to srgb, 203 nits
/// white"; "none" where nothing is.
const char* tone_map_of(const FrameColour& colour);

}  // namespace tessera
