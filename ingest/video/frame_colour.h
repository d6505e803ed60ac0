// What a video states about the colours and fields of its frames: matrix, range, transfer curve,
// primaries and interlacing, as far as the conversion to sRGB depends on them.
#pragma once
#include <string>

#include "ingest/video/clip.h"

struct AVCodecParameters;
struct AVFrame;

namespace tessera {

/// Unstated matrices are BT.601 below 720 lines, BT.709 from there; unstated ranges are limited but
/// of RGB, grey and the full-range formats.
FrameColour colour_of(const AVFrame& frame);
/// Of a video before its frames are decoded, as far as its container and its headers state it.
FrameColour colour_of(const AVCodecParameters& track);

/// Why frames of this colour cannot become sRGB, with the ffmpeg command that converts them; empty
/// where they can. It follows the name of the file.
std::string colour_refusal(const FrameColour& colour);
/// For people: "SDR", "SDR in BT.2020", "HLG", "PQ".
std::string colour_name(const FrameColour& colour);

/// What is done to frames of this colour, as a prepared scene records it: "hlg to srgb, 203 nits
/// white"; "none" where nothing is.
const char* tone_map_of(const FrameColour& colour);

}  // namespace tessera
