// What keys and names of frames may say about their cameras. Each way to read the names gives a
// label a frame; whether the labels are cameras is decided elsewhere (camera_groups.h).
#pragma once
#include <string>
#include <vector>

#include "ingest/poses/stated_object.h"

namespace tessera {

using CameraLabels = std::vector<std::string>;  // one a frame; empty where the name has none

/// What an entry states under `camera`, `cam_id`, `cameraName` and the like, a text or a whole
/// number, which counts as read; empty: none.
std::string camera_key_of(const StatedObject& entry);

/// Readings of the names of frames ("images/cam00_0001"), in the order in which they are tried: the
/// folders that differ, what stands before the number of the file, both, the whole name of the
/// file, the last number of it ("0001_00").
std::vector<CameraLabels> camera_labels(const std::vector<std::string>& names);

}  // namespace tessera
