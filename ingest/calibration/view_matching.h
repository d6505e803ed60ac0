// Finds the camera of each clip of a rig among cameras that another program has named.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "ingest/poses/lens.h"

namespace tessera {

struct MatchedViews {
  std::vector<std::optional<size_t>> camera;  // one a clip: its place in the list of cameras
  /// Why no clip has a camera, with both lists of names, without a remedy; empty where some have.
  std::string refusal;
};

/// A camera belongs to a clip
/// - by name: it is called as the clip, with or without extension ("cam00.png"), by the file or a
///   folder of its path ("images/cam00.jpg", "cam00/0000.png"), or with a number behind
///   ("cam00_0000.png");
/// - else by number, where the numbers that the names of all clips end with are those of all
///   cameras, one to one: "image1.png" of "cam01". An offset is not guessed.
/// Where the two differ, or a name fits two clips, none is taken. Several cameras of one clip (its
/// frames, in a COLMAP model) must have one pose; else the camera moves, and none is taken. `clips`
/// are unique.
MatchedViews match_views(const std::vector<RigCamera>& cameras,
                         const std::vector<std::string>& clips);

}  // namespace tessera
