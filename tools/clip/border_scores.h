// How wrong the image of a camera changes between two timesteps, where both are of one window of a
// clip and where a border lies between them. Both are measured in the same way, so that a jump at
// a border shows as a larger number. temporal_scores.h has the same error of a whole camera.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recon4d/evaluation/render.h"

namespace tessera {

/// Means of |change of the render − change of the truth| in steps of 8-bit values, over all pixels
/// and over those whose truth changes by more than DynamicRegions::kThreshold in a channel; nothing
/// where there is no such pixel.
struct ChangeErrors {
  std::optional<double> all, moving;
};

struct BorderScore {
  ChangeErrors inside, border;
};

/// Takes the frames of a split in the order of windows, in each of them in the order of time. It
/// keeps an image of each camera.
class BorderMeter {
 public:
  /// The frames that come next are of another window.
  void begin_window() { ++window_; }
  void add(const Frame& frame, const RenderedImage& image);
  BorderScore score() const;

 private:
  struct Shown {
    Frame frame;
    std::vector<float> drawn;  // [3, height, width] 8-bit units
    int64_t window = 0;
  };
  struct Sums {
    double all = 0, moving = 0;
    int64_t all_count = 0, moving_count = 0;
  };

  std::map<std::string, Shown> last_;  // by camera
  Sums inside_, border_;
  int64_t window_ = 0;
};

}  // namespace tessera
