// Converts HLG, PQ and BT.2020 values to 8-bit sRGB through the light of a display. Sources: ITU-R
// BT.2100-2 (curves), BT.2408-7 (diffuse white at 203 nits), BT.2087-0 (primaries), IEC 61966-2-1.
#pragma once
#include <cstddef>
#include <cstdint>

#include "ingest/video/frame_colour.h"

namespace tessera {

inline constexpr double kWhiteNits = 203;  // BT.2408, table 1: HLG 75 %, PQ 58 %

/// Light of the scene, 0 to 1, that the HLG signal 0 to 1 stands for: the inverse OETF of BT.2100.
double hlg_scene_light(double signal);
/// Light of the display in nits, 0 to 10,000, of the PQ signal 0 to 1: the EOTF of BT.2100.
double pq_nits(double signal);

/// The 16-bit value of signal 1 in swscale's RGB48; what lies above is taken for it.
inline constexpr int kFullSignal = 255 * 256;

/// `rgb`: [pixels, 3] signals, 0 to kFullSignal; `srgb`: [pixels, 3]. HLG is shown by the reference
/// display of 1,000 nits (system gamma 1.2), and 203 nits become white in HLG and PQ. BT.2020 SDR
/// is shown with gamma 2.4 (BT.1886) and returned by it, so grey keeps its value. Light in BT.709
/// primaries is clipped to [0, 1].
void srgb_of(const FrameColour& colour, const uint16_t* rgb, size_t pixels, uint8_t* srgb);

}  // namespace tessera
