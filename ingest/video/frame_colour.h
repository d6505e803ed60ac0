// What a video states about the colours and fields of its frames: matrix, range, transfer curve,
// primaries and interlacing, as far as the conversion to sRGB depends on them.
#pragma once
#include <string>

struct AVCodecParameters;
struct AVFrame;

namespace tessera {

/// How code values stand for light. ITU-R BT.2100 (HLG, PQ).
enum class TransferCurve {
  kSdr,  // BT.709, BT.601, sRGB, BT.2020 and what is unstated; values are taken as sRGB
  kHlg,  // ARIB STD-B67
  kPq,   // SMPTE ST 2084
  kNone  // linear, logarithmic, DCDM: has no conversion to sRGB here
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
  bool interlaced = false;                // the lines of two times alternate
  const char* transfer_name = "unknown";  // as FFmpeg names what is stated
  const char* matrix_name = "unknown";

  static constexpr int kNoMatrix = -1;
  /// Its values are sRGB with BT.709 primaries as they are.
  bool is_srgb() const {
    return transfer == TransferCurve::kSdr && primaries == ColourPrimaries::kBt709;
  }
};

/// Unstated matrices are BT.601 below 720 lines, BT.709 from there; unstated ranges are limited but
/// of RGB, grey and the full-range formats.
FrameColour colour_of(const AVFrame& frame);
/// Of a video before its frames are decoded, as far as its container and its headers state it.
FrameColour colour_of(const AVCodecParameters& track);

/// Why frames of this colour cannot become sRGB, with the ffmpeg command that converts them; empty
/// where they can. It follows the name of the file.
std::string colour_refusal(const FrameColour& colour);
/// The same of interlaced frames, which are used as they are; empty where they are progressive.
std::string interlaced_warning(const FrameColour& colour);
/// For people: "SDR", "SDR in BT.2020", "HLG", "PQ".
std::string colour_name(const FrameColour& colour);

/// What is done to frames of this colour, as a prepared scene records it: "hlg to srgb, 203 nits
/// white"; "none" where nothing is.
const char* tone_map_of(const FrameColour& colour);

}  // namespace tessera
