// Bounding boxes of named objects from the ground_truth.json of a synthetic rig, for the frames of
// the scene that was prepared from it.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "recon4d/evaluation/timestep_scores.h"

namespace tessera {

class ObjectBoxes {
 public:
  /// Errors: InputError that names the file: not readable, without boxes.
  explicit ObjectBoxes(const std::filesystem::path& file);

  /// Errors: InputError where a camera of these splits is not in the file, or has another number of
  /// frames there.
  void check_fits(const Scene& scene, const std::vector<Split>& splits) const;
  /// Of the objects that the frame shows, in pixels of its image, whatever its scale.
  NamedBoxes of(const Frame& frame) const;

 private:
  std::string file_;
  double width_ = 0, height_ = 0;                           // of the images of the capture, pixels
  std::map<std::string, std::vector<NamedBoxes>> cameras_;  // one a frame
};

}  // namespace tessera
