// Comparisons of the motion of two clips: a coarse offset from the time and position of their
// motion, and a fine one from the distances of moving features to their epipolar lines.
#pragma once
#include <optional>
#include <vector>

#include "ingest/clocks/clip_motion.h"
#include "ingest/clocks/offset_solver.h"
#include "ingest/poses/lens.h"

namespace tessera {

/// With all points where a lens without distortion shows them; `width` and `height` are the
/// video's. Points without such a place are dropped.
MovingFeatures straightened(const MovingFeatures& frame, const RigCamera& camera, int width,
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

/// Matches frames of a and b that show the same time if b's clock is set later than a's by `shift`
/// of a's time, among features within `gate` of their epipolar lines. Misses and gate are in pixels
/// of an image of 480 pixels.
std::vector<EpipolarMiss> epipolar_misses(const PosedFeatures& a, const PosedFeatures& b,
                                          const ClockShift& shift, double gate);

/// Offset of b − a near `start`, in the middle of a's features, and its rate, by matching again at
/// each better offset. Nothing where too few moving points match.
std::optional<PairShift> fine_offset(const PosedFeatures& a, const PosedFeatures& b, double start);

/// Correlates the clips' motion over time, separately on each plane through both camera centres,
/// which no point leaves in the image of one of the cameras only. `sigma` is a frame. Nothing
/// where no shift stands out.
std::optional<PairOffset> coarse_offset(const MotionEnergy& a, const MotionEnergy& b,
                                        const RigCamera& camera_a, const RigCamera& camera_b);

}  // namespace tessera
