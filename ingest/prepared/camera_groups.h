// Decides which frames of a transforms file with times are of one camera, where a prepared scene
// does not state it.
#pragma once
#include <string>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

/// What is known of a frame for its camera.
struct UngroupedFrame {
  std::string name;     // "images/cam00_0001"
  std::string listing;  // the camera by the file: the frame's folder, else its split
  bool stated = false;  // `listing` is that of a prepared scene, and stays
  Split split = Split::kTrain;
  double time = 0;       // in any unit
  int view = 0;          // equal for frames of one pose and one set of intrinsics (equal_views.h)
  std::string camera{};  // under a key like `camera_id`; empty: none
};

struct CameraGroups {
  std::vector<std::string> cameras;  // one a frame
  bool regrouped = false;            // the cameras are not those of UngroupedFrame::listing
  std::string note;  // "read as 6 cameras with 8 images each, by their poses"; empty otherwise
};

/// A reading (a label a frame) is of cameras where each label has one image a time and each view
/// that comes at several times one label; splits are looked at alone. In this order:
/// - what keys and names say (camera_labels.h), if the labels film half of the clip together and
///   have two images in the mean;
/// - the folders or splits, of which one in ten frames may differ;
/// - views that come at several times, and a moving camera of each split's other frames;
/// - a camera each.
/// Cameras are called as the names of their frames where these tell them apart, else camera_0,
/// camera_1 … The order of `frames` changes nothing. All times equal: the folders.
CameraGroups group_cameras(const std::vector<UngroupedFrame>& frames);

}  // namespace tessera
