// What: which frames of several cameras show the same moment, and an even choice of moments.
// Not: clocks: times are taken as they are; cameras may be apart by parts of a frame.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace tessera {

/// A frame by what tells its moment.
struct FrameTime {
  std::string camera;
  double time = 0;  // normalised
  int index = 0;    // the caller's
};

struct Moment {
  double time = 0;          // of the camera with the most moments
  std::vector<int> frames;  // FrameTime::index, in the order given
};

/// Moments in order of time: those of the camera that has the most (the first by name), each with
/// the frames nearest to it, as far as half of that camera's smallest frame gap. Where no camera
/// has two moments, frames of equal times go together.
std::vector<Moment> group_moments(const std::vector<FrameTime>& frames);

/// At most `count` of the moments, evenly spread, the first and the last among them where count
/// is 2 or more.
std::vector<Moment> spread_moments(const std::vector<Moment>& moments, int64_t count);

}  // namespace tessera
