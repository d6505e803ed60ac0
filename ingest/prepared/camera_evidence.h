// Tests a reading of the cameras of frames (a label a frame) against their times, views and names.
#pragma once
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "ingest/prepared/camera_labels.h"
#include "ingest/scene.h"

namespace tessera {

/// What is known of a frame for its camera.
struct UngroupedFrame {
  std::string name;     // "images/cam00_0001"
  std::string listing;  // the camera by the file: the frame's folder, else its split
  bool stated = false;  // `listing` is stated as the camera, and stays
  Split split = Split::kTrain;
  double time = 0;  // in any unit
  int view = 0;     // equal for frames of one pose and one set of intrinsics (equal_views.h)
};

using FrameNumbers = std::vector<size_t>;
using LabelGroups = std::map<std::string, FrameNumbers>;  // by label

/// Of frames for which no camera is stated. A view is fixed where frames of a split show it at
/// several times, one at each. Each split is looked at alone: splits share times.
class CameraEvidence {
 public:
  /// `frames` stays alive as long as this, and has one or more.
  explicit CameraEvidence(const std::vector<UngroupedFrame>& frames);

  /// By split, the frames that have no stated camera.
  const std::map<Split, FrameNumbers>& open() const { return open_; }
  bool has_one_time() const { return latest_ == 0; }
  /// Views that are fixed in some split.
  std::set<int> fixed_views() const;
  /// How many of `frames` have a time that an earlier one of them has, too.
  size_t repeated_times(const FrameNumbers& frames) const;

  /// Whether the folders or splits are cameras: nearly all have one image a time and no fixed view
  /// under several, and the names within one are not those of several cameras.
  bool listing_holds() const;
  /// Whether the labels, which names gave, are cameras: each has one image a time, fixed views are
  /// under one label each and do not come in turns, and labels have two images in the mean.
  bool names_hold(const CameraLabels& labels) const;
  /// Whether most frames are of fixed views, and each label has one.
  bool are_views(const CameraLabels& labels) const;

 private:
  bool is_fixed(size_t frame) const;
  size_t repeated_times_of(const CameraLabels& labels, const FrameNumbers& frames) const;
  size_t scattered_views(const CameraLabels& labels, const FrameNumbers& frames) const;
  bool mixes_views(const FrameNumbers& group) const;
  bool names_several(const FrameNumbers& group) const;

  const std::vector<UngroupedFrame>& frames_;
  const std::vector<int> times_;  // equal numbers for equal times, ascending
  const int latest_;
  std::vector<NumberedName> numbered_;
  CameraLabels listing_;
  std::map<Split, FrameNumbers> open_;
  std::set<std::pair<Split, int>> fixed_;
};

/// The frames of each label.
LabelGroups by_label(const CameraLabels& labels, const FrameNumbers& frames);

}  // namespace tessera
