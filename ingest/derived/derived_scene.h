// The description of a scene of images that is made of a prepared scene: of all or some of its
// frames, whether these are image files or clips.
#pragma once
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "ingest/scene.h"

namespace tessera {

/// Errors: InputError: the folder is no prepared scene.
void check_is_prepared(const std::filesystem::path& folder);

/// What transforms.json of the source says of each frame but its time: of its clip, or of the frame
/// itself.
class FrameEntries {
 public:
  explicit FrameEntries(const nlohmann::ordered_json& file);

  /// As an image file. Numbers are those of the file, so that they come back to the bit.
  nlohmann::ordered_json image_entry(const Frame& frame) const;

 private:
  std::map<std::string, nlohmann::ordered_json> of_camera_, of_name_;
};

/// What `file` says that is not about frames, for those of `scene`: its clock and whether it has
/// points. The list of frames is empty.
nlohmann::ordered_json description_of(nlohmann::ordered_json file, const Scene& scene);

/// The mask that a frame's entry names, where it does and `to` has it not. Its name in `to`, which
/// the entry has then, leads out of no folder.
void copy_mask(const std::filesystem::path& from, nlohmann::ordered_json& entry,
               const std::filesystem::path& to);

}  // namespace tessera
