// Flicker: how much the images of a camera that stands still change over time where the truth does
// not, and how wrong changes are. Source: failure modes A14.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recon4d/evaluation/render.h"

namespace tessera {

/// Of one camera over its scored frames. Units: steps of 8-bit values, images clamped to [0, 1]
/// and not rounded.
struct FlickerScore {
  std::string camera;
  int64_t timesteps = 0;
  /// Mean of |(r(t+1) − r(t)) − (g(t+1) − g(t))|, r: rendered, g: ground truth.
  double change_error = 0;
  /// Where g never changes (its standard deviation over time is below kStillDeviation): share of
  /// the values, mean standard deviation of r and, as what noise alone makes, of g.
  double still_share = 0;
  std::optional<double> still_deviation, still_deviation_truth;

  static constexpr double kStillDeviation = 2;
};

/// Takes the frames of a split one after another. A camera counts when its scored frames show it in
/// one place at two timesteps or more and come in the order of time. It takes 61 bytes a pixel from
/// a camera's first frame to its last.
class FlickerMeter {
 public:
  /// `frames`: how many of each camera will come.
  explicit FlickerMeter(std::map<std::string, int64_t> frames) : left_(std::move(frames)) {}
  void add(const Frame& frame, const RenderedImage& image);
  std::vector<FlickerScore> scores() const;  // by name of camera

 private:
  struct Sums {
    const Frame* last = nullptr;
    std::vector<float> previous;            // [3, height, width] of the last image, 8-bit units
    std::vector<float> mean[2], square[2];  // rendered, truth: Welford's running sums
    std::vector<uint8_t> used;              // [height, width] by all masks so far
    double change_sum = 0;
    int64_t change_count = 0, timesteps = 0;
    bool broken = false;
  };
  static void take(const Frame& frame, const RenderedImage& image, Sums& sums);
  static void start(Sums& sums, const Frame& frame);
  static FlickerScore score(const std::string& camera, const Sums& sums);

  std::map<std::string, int64_t> left_;         // frames of each camera
  std::map<std::string, Sums> cameras_;         // those that are not complete
  std::map<std::string, FlickerScore> scores_;  // the others
};

}  // namespace tessera
