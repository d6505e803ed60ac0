// Which mask files belong to the frames of a recording, by the names that programs of segmentation
// give them: numbers that count the frames of the clip. Names are compared without regard to case.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "ingest/images/image_index.h"
#include "ingest/video/clip.h"

namespace tessera {

/// Finds masks below a folder and collects what is to be said about them.
class MaskFiles {
 public:
  explicit MaskFiles(const std::filesystem::path& folder) : folder_(folder), index_(folder) {}

  /// The mask of an image, "a/b.jpg": a/b.jpg.png, else a/b with the extension of any image, as
  /// ImageIndex finds them. Empty where there is none, and without an image.
  std::filesystem::path of_image(const std::string& image);

  /// The mask of each frame of the clip; empty: it has none. Of "cam00" the numbered images of the
  /// folder cam00 (also cam00/masks, masks/cam00), or those called cam00_00012.png; of a camera
  /// that is `alone` also those that lie in the folder without a camera's name. Numbers are those
  /// of the clip's images where all are; else frames counted from 0, or from 1 where they are 1 to
  /// the number of frames. Frames without a number there have the mask of all: cam00.png.
  std::vector<std::filesystem::path> of_clip(const RigClip& clip, bool alone);

  /// What was not read as it may be expected: counts that differ, videos, several files that fit.
  std::vector<std::string> warnings() const;
  /// That masks were counted from 1.
  std::vector<std::string> notes() const;

 private:
  using Numbered = std::map<int64_t, std::filesystem::path>;
  struct Series {
    std::filesystem::path place;  // folder, or folder and what the names begin with
    Numbered masks;
  };

  Series series_of(const std::string& camera, bool alone);
  /// The number of the first frame, or nothing in `masks` fits.
  int64_t first_number(const RigClip& clip, const Series& series);
  void note_count(const RigClip& clip, const Series& series, int64_t first);

  std::filesystem::path folder_;
  ImageIndex index_;
  std::vector<std::string> counted_from_1_;  // cameras
  std::vector<std::string> warnings_;
};

/// What lies in a folder of masks: "cam00 (24 images), cam01.mp4, a.png"; of each kind the first
/// ones.
std::string contents_of_masks(const std::filesystem::path& folder);

}  // namespace tessera
