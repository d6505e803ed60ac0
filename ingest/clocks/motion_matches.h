// What: moving features that two posed cameras both see, and how far each misses its epipolar line
//       at a supposed offset of the clocks.
// Not: the offset that follows from the misses (offset_solver.h).
#pragma once
#include <vector>

#include "ingest/clocks/clip_motion.h"
#include "ingest/clocks/offset_solver.h"
#include "ingest/poses/rig_camera.h"

namespace tessera {

/// Moves all points of the features to where a lens without distortion shows them; `width` and
/// `height` are the video's. Points without such a place are dropped.
void straighten(std::vector<MovingFeatures>& features, const RigCamera& camera, int width,
                int height);

/// A posed clip's features, straightened, and its pinhole camera in pixels of its video.
struct PosedFeatures {
  Camera camera;
  std::vector<MovingFeatures> frames;
  double frame_seconds = 0;
};

/// By how much a clock is set later: offset + rate · (t − middle), t on another clock; seconds.
struct ClockShift {
  double offset = 0, rate = 0, middle = 0;
  double at(double t) const { return offset + rate * (t - middle); }
};

/// Matches frames of a and b that show one instant if b's clock is set later than a's by `shift` of
/// a's time, among features within `gate` of their epipolar lines. Misses and gate are in pixels of
/// an image of 480 pixels.
std::vector<EpipolarMiss> epipolar_misses(const PosedFeatures& a, const PosedFeatures& b,
                                          const ClockShift& shift, double gate);

/// Offset of b − a near `start`, in the middle of a's features, and its rate, by matching again at
/// each better offset. Nothing where too few moving points match.
std::optional<PairShift> fine_offset(const PosedFeatures& a, const PosedFeatures& b, double start);

}  // namespace tessera
