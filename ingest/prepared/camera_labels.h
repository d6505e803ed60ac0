// What the names of frames may say about their cameras. Each way to read the names gives a label a
// frame; whether the labels are cameras is decided elsewhere (camera_groups.h).
#pragma once
#include <string>
#include <vector>

#include "ingest/images/image_names.h"

namespace tessera {

using CameraLabels = std::vector<std::string>;  // one a frame; empty where the name has none

/// Readings of the names of frames ("images/cam00_0001"), in the order in which they are tried: the
/// folders that differ, what stands before the number of the file, both, the whole name of the
/// file, the last number of it ("0001_00").
std::vector<CameraLabels> camera_labels(const std::vector<std::string>& names);

/// One a frame: its folders that differ with what stands before the number of the file, and that
/// number; −1 where the name has none.
std::vector<NumberedName> numbered_names(const std::vector<std::string>& names);

}  // namespace tessera
