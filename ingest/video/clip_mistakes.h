// Mistakes in the files of a rig that no reader can fail at: one recording under two names, images
// that are numbered from another number, and an input that froze.
#pragma once
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "ingest/video/clip.h"

namespace tessera {

/// One line for each recording that several clips hold byte for byte. Errors: InputError: a file
/// cannot be read.
std::vector<std::string> copied_clips(const std::vector<RigClip>& clips);

/// Which numbered images are as many as those of most cameras, at the same distances, and begin at
/// another number, in one line; empty where none do. Their timelines are read.
std::string shifted_numbers(const std::vector<RigClip>& clips);

/// The longest stretch of a clip that repeats one image, as a recorder writes when its input is
/// gone.
struct FrozenStretch {
  std::string camera;
  int64_t frames = 0;          // with the one that is repeated; 0: no frame was seen
  double first = 0, last = 0;  // seconds of its first and last frame
};

/// Sees the frames of a clip in their order.
class FrozenFrames {
 public:
  explicit FrozenFrames(std::string camera) { longest_.camera = std::move(camera); }
  void see(const Image8& image, double seconds);
  const FrozenStretch& longest() const { return longest_; }

 private:
  Image8 image_;  // that the stretch repeats
  FrozenStretch now_, longest_;
};

/// A line for each camera that repeats an image for five frames or more and at least three times as
/// long as the median camera does: where all stand still, so does the scene.
std::vector<std::string> frozen_warnings(const std::vector<FrozenStretch>& cameras);

}  // namespace tessera
