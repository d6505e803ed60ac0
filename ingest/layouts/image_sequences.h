// Finds numbered images of a folder as sequences: one for each camera of a rig, or all images of
// one camera.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/images/image_paths.h"
#include "ingest/video/frame_timing.h"

namespace tessera {

struct ImageSequence {
  std::string camera;  // "cam02": the name of its folder, or what its files' names begin with
  std::filesystem::path path;         // its folder, or the folder of all and its name, for messages
  std::vector<NumberedImage> images;  // numbers increase
  std::vector<std::filesystem::path> unread{};  // in its folder: not numbered, or numbers again
};

/// Whether images are those of several cameras that film together.
enum class RigEvidence {
  kNone,     // there are no two sequences, or their numbers have nothing to do with each other
  kUnclear,  // equal numbers under names that are no cameras', or cameras with other numbers
  kRig       // names of cameras, and at least nine tenths of the numbers are of all of them, or of
             // all but a quarter of three or more cameras
};

struct ImageSequences {
  std::vector<ImageSequence> cameras;  // by name
  RigEvidence evidence = RigEvidence::kNone;
  std::string seen;         // "3 folders of numbered images (a, b, c), 8 numbers in all of them"
  bool in_folders = false;  // one folder a sequence; false: all lie in one folder
  std::vector<std::filesystem::path> unread{};  // what lies beside them and looks alike
  std::optional<Rational> number_seconds{};     // where the numbers are times
  std::string times{};                          // what these are, for people
};

/// Of images directly in `capture` or its `images`, by their names: cam00_0001.png,
/// camera_3_img_0001.jpg, 0001_cam00.png. Without such images, of sub-folders of `capture` or its
/// `images`, `ims`, `frames` or `rgb`: cam00/0001.png, 3/000001.jpg, cam00/images/0001.png;
/// capture/images… are sizes of one photo set, never cameras.
ImageSequences find_image_sequences(const std::filesystem::path& capture);

/// How numbered images of so many cameras are read, for people; `times`: of ImageSequences; `rate`:
/// numbers a second where they are none.
std::string reading_text(size_t cameras, const std::string& times, double rate);

/// All images of `folder` as one sequence: by the numbers that their names end with, where these
/// differ, else counted in the order of names.
ImageSequence single_sequence(const std::filesystem::path& folder);

/// Whether the images of `folder` are numbered from 0 or 1 without a gap, twenty or more, as a
/// video that was cut into images is.
bool looks_like_video(const std::filesystem::path& folder);

}  // namespace tessera
