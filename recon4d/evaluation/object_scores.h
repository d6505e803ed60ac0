// PSNR of single objects: of the pixels in a box about each, over time, which shows whether a fast
// object is where it should be when the rest of the image is right.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recon4d/evaluation/timestep_scores.h"

namespace tessera {

/// Pixels [x0, x1) × [y0, y1) of a frame; what lies outside the image does not count.
struct ObjectBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
using NamedBoxes = std::map<std::string, ObjectBox>;

struct ObjectScore {
  std::string name;
  double psnr = 0;                       // dB, of the mean squared error over all its pixels
  std::vector<TimestepScore> timesteps;  // that show it, ascending; without moving pixels apart
};

/// Takes the scored views in any order. Pixels that masks ignore do not count.
class ObjectMeter {
 public:
  /// `boxes`: of the objects that the frame shows.
  void add(const Frame& frame, const Image8& drawn, const NamedBoxes& boxes);
  std::vector<ObjectScore> scores() const;  // by name; objects without a pixel are left out

 private:
  struct Object {
    PixelSums all;
    TimestepMeter timesteps;
  };
  std::map<std::string, Object> objects_;
};

}  // namespace tessera
