// Decides which frames of a transforms file with times are of one camera, where the file does not
// state it: by folders, by equal views at several times, and by names.
#pragma once
#include <string>
#include <vector>

#include "ingest/prepared/camera_evidence.h"

namespace tessera {

struct CameraGroups {
  std::vector<std::string> cameras;  // one a frame
  bool regrouped = false;            // the cameras are not those of UngroupedFrame::listing
  std::string note;  // "read as 6 cameras with 8 images each, by their poses"; empty otherwise
};

/// Folders (or splits) are the cameras where each has one image a time in a split, and neither
/// views nor names contradict (CameraEvidence::listing_holds). Otherwise the first reading of the
/// names (camera_labels.h) that holds. Otherwise each view that is seen at several times is a fixed
/// camera, and of the other frames a split's are one moving camera where they have one image a
/// time, else a camera each. Cameras are called as the names of their frames where these tell them
/// apart, else camera_0, camera_1 … The order of `frames` changes nothing. All times equal: the
/// folders.
CameraGroups group_cameras(const std::vector<UngroupedFrame>& frames);

}  // namespace tessera
