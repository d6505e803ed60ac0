// PSNR of each timestep over all scored cameras, and PSNR of single objects from the pixels in a
// box around each. They show at which timesteps, and for which fast objects, the motion is wrong.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recon4d/evaluation/pixel_sums.h"

namespace tessera {

struct TimestepScore {
  double time = 0;           // normalised, of the first view of the timestep
  int64_t frame_number = 0;  // likewise
  int64_t views = 0;
  /// dB, of the mean squared error over the pixels of all views, 8-bit images.
  double psnr = 0;
  std::optional<double> psnr_dynamic;  // of the moving pixels; nothing where there is none
};

/// Takes the scored views in any order.
class TimestepMeter {
 public:
  void add(const Frame& frame, const ViewPixelSums& sums);
  std::vector<TimestepScore> scores() const;  // timesteps ascend

 private:
  struct Timestep {
    double time = 0;
    int64_t frame_number = 0, views = 0;
    PixelSums moving, all;
  };
  std::map<int64_t, Timestep> timesteps_;  // by Frame::timestep
};

/// The timestep of lowest PSNR, the first one of several; nothing where there is none.
std::optional<TimestepScore> worst_timestep(const std::vector<TimestepScore>& timesteps);

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
