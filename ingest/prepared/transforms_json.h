// Reads transforms*.json of D-NeRF, NeRF-synthetic, Nerfstudio and prepared scenes as a list of
// frames with poses, stated intrinsics and times. Image sizes are unknown here, so intrinsics stay
// as stated (intrinsics.h).
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "ingest/clocks/timesteps.h"
#include "ingest/poses/intrinsics.h"
#include "ingest/poses/transforms_values.h"
#include "ingest/prepared/scene_clip.h"
#include "ingest/scene.h"

namespace tessera {

struct TransformsFrame {
  std::string where;            // "transforms_train.json, frame 3 (./train/r_3)", for messages
  std::filesystem::path image;  // an existing file; empty: a frame of a clip
  int clip = -1;                // of TransformsCapture::clips; −1: it is an image file
  int64_t ticks = 0;            // within the clip
  std::filesystem::path mask;   // mask_path, an existing file; empty: none is stated
  std::string name;             // file_path without "./", ".." and extension; unique
  std::string camera_name;
  bool camera_is_stated = false;  // in a `tessera` object
  std::string camera_key;         // under a key like `camera_id`; empty: none
  int64_t frame_number = 0;
  Split split = Split::kTrain;
  std::optional<double> time;  // capture's own unit; normalised already in a prepared scene
  std::map<std::string, double> other_times;  // by key (frame_times.h)
  StatedIntrinsics intrinsics;                // of the frame, else of the file
  StatedLens lens;                            // likewise; a pinhole where read_transforms read it
  Camera camera;                              // pose only; of a clip's frame all of it
};

struct TransformsCapture {
  std::vector<std::filesystem::path> files;  // the json files, in reading order
  std::vector<TransformsFrame> frames;       // never empty; all have a time or none has
  std::vector<SceneClip> clips;              // of a prepared scene of videos
  std::string points_file;                   // ply_file_path, empty when not stated
  std::optional<TimeAxis> prepared_axis;     // set where a `tessera` object is present
  bool prepared_static = false;
  int64_t prepared_static_of = 0;           // Scene::static_of
  std::set<std::string> measured_clocks{};  // of Scene
  Similarity prepared_from_source;   // of the poses' world; identity without a `tessera` object
  std::vector<std::string> missing;  // file_path of frames without an image, left out
  std::vector<std::string> warnings;
  std::vector<std::string> notes;  // how times and cameras were found where no file states them
};

/// Reads what can be trained on as it is from `folder`: transforms_train/val/test.json where
/// transforms_train.json is there, else transforms.json. Errors: InputError naming file, frame and
/// remedy; also for an image that is missing and for lens distortion.
TransformsCapture read_transforms(const std::filesystem::path& folder);

/// The same of a capture that is to be prepared: lenses are read, and frames whose image is not
/// there are listed and left out. Errors: as above, and where no image is there.
TransformsCapture read_transforms_capture(const std::filesystem::path& folder);

/// One transforms file as a camera path: the images it names need not be there (TransformsFrame::
/// image is empty), and a frame without file_path is named by its number. Errors: as above.
TransformsCapture read_camera_path(const std::filesystem::path& file);

/// True when `folder` has a file that read_transforms would read.
bool has_transforms(const std::filesystem::path& folder);
/// True when `folder` holds a transforms.json with a `tessera` object.
bool is_prepared_scene(const std::filesystem::path& folder);
/// Relative names of the files of a prepared scene; nothing where there is none. Names that its
/// transforms.json has of something else may be among them.
std::set<std::string> files_of_scene(const std::filesystem::path& folder);

/// One entry a frame of `capture`. Without times the capture is static. Errors: InputError: times
/// all equal (unless `allow_static`), or a prepared scene whose times or axis cannot be.
NormalisedTimes times_of(const TransformsCapture& capture, bool allow_static);

}  // namespace tessera
