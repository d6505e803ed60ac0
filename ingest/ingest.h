// Converts any capture to a prepared scene on disk. This header is the only entry point of the
// conversion; progress is reported through a callback.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ingest/camera_row.h"
#include "kernels/base/enum_names.h"
#include "kernels/base/errors.h"

namespace tessera {

class PixelSearch;

enum class CaptureLayout { kTransforms, kN3dv, kColmap, kLlff, kVideos, kSequences, kPhotos };

/// The meaning of images without a video: synchronous cameras, photos of a static scene, or one
/// moving camera in a scene that may move.
enum class ImageLayout { kRig, kPhotos, kMoving };
template <>
inline constexpr const char* kEnumNames<ImageLayout>[] = {"rig", "photos", "moving"};

enum class SyncMethod { kAuto, kNone, kContainer, kAudio, kMotion };
template <>
inline constexpr const char* kEnumNames<SyncMethod>[] = {"auto", "none", "container", "audio",
                                                         "motion"};

/// Initial cloud of the prepared scene: none, what the capture has, or a plane sweep added to it.
enum class CloudDensity { kNone, kSparse, kDense };
template <>
inline constexpr const char* kEnumNames<CloudDensity>[] = {"none", "sparse", "dense"};

/// What a prepared scene of clips has: an image file a frame, or the source videos by reference.
/// kAuto: the videos, where the clip is longer than kLongClip and its frames can stay there.
enum class FramesAs { kPng, kVideo, kAuto };
template <>
inline constexpr const char* kEnumNames<FramesAs>[] = {"png", "video", "auto"};

/// What an undistorted image keeps of the view. kValid: it is cropped until all pixels are valid;
/// kFull: up to 120 degrees, and pixels that the source does not show are masked; kAuto: kFull
/// where the crop would take more than a tenth of the width or height.
enum class FieldOfView { kAuto, kFull, kValid };
template <>
inline constexpr const char* kEnumNames<FieldOfView>[] = {"auto", "full", "valid"};

inline constexpr double kLongClip = 20;  // seconds; a longer one is trained window by window

inline constexpr int64_t kCloudPoints = 100000;  // most that a plane sweep finds by default
inline constexpr double kImageRate = 30;         // numbers per second of images that state none

struct SyncOptions {
  SyncMethod method = SyncMethod::kAuto;  // container times, else sound, else motion
  std::filesystem::path offsets;          // file of stated offsets; it wins over the method
};

/// Where poses come from.
struct PoseSource {
  enum class Kind { kFound, kColmap, kN3dv, kLlff, kCameras };
  using enum Kind;

  Kind kind = kFound;               // kFound: what the capture has
  std::filesystem::path cameras{};  // of kCameras: a file or folder that states them
};

/// Which cameras share estimated intrinsics: those of one image size, or none.
enum class Intrinsics { kShared, kPerCamera };
template <>
inline constexpr const char* kEnumNames<Intrinsics>[] = {"shared", "per-camera"};

struct PoseOptions {
  PoseSource source;
  std::string lens_model;  // COLMAP's name; empty: the simplest that fits
  Intrinsics intrinsics = Intrinsics::kShared;
  bool strict = false;          // an unregistered camera is an error
  std::filesystem::path cache;  // where COLMAP's results are kept for other outputs, too; empty:
                                // nowhere

  bool intrinsics_per_camera() const { return intrinsics == Intrinsics::kPerCamera; }
};

struct IngestOptions {
  double scale = 1;                     // (0, 1]: size of the prepared frames by the source's
  std::optional<int64_t> frames;        // first N frames of each camera; all by default
  double start = 0;                     // videos: seconds after the first common timestep
  std::optional<double> duration;       // videos: seconds; to the last common timestep by default
  std::optional<double> fps;            // videos: frames taken per second; all by default
  std::vector<std::string> cameras;     // videos: those that are taken, by name; all by default
  std::vector<std::string> held_out;    // camera names that become the test split; empty: of
                                        // several videos the innermost, of N3DV the first
  bool fit_exposure = false;            // equalise exposure and white balance of training cameras
  bool allow_static = false;            // accept a capture whose times are all equal
  bool keep_world = false;              // no world normalisation (world_normalisation.h)
  std::optional<CaptureLayout> layout;  // read it as this, where a folder can be read as several
  std::optional<ImageLayout> image_layout;  // of images; by default by their names
  std::optional<double> image_rate;  // numbered images: numbers per second; by default `fps`,
                                     // which chooses no frames of them, else 30
  std::string images;                // photo sets: the folder of the photos; empty: images
  FramesAs frames_as = FramesAs::kPng;
  FieldOfView field_of_view = FieldOfView::kAuto;  // of images whose lens is removed
  bool strict = false;  // missing or unreadable images and photos without a
                        // pose are errors; otherwise they are warned of
  // Images 0, N, 2N … by name are the test split, of photo sets, of transforms files that state no
  // test frames, and frames of a single camera; 0: none. By default 8 for photos and for a camera
  // that moves, as in the usual protocol.
  std::optional<int64_t> test_every;
  std::optional<CloudDensity> cloud;    // by default dense where three cameras share timesteps
  int64_t cloud_points = kCloudPoints;  // at most, found by the sweep
  std::filesystem::path masks;  // folder of masks named as images or cameras; it replaces those
                                // that a capture states; empty: the stated ones
  SyncOptions sync;             // videos
  /// Videos: Camera::readout of cameras by name, seconds; of "": all others. Beside those that a
  /// calibration states.
  std::map<std::string, double> readouts{};
  PoseOptions poses;           // videos and photos
  std::filesystem::path work;  // where estimates are kept for the next time; empty: out + ".work"
  bool invert_masks = false;   // black is used, not ignored
  bool sample = false;         // a few timesteps of videos, images at most 960 pixels wide: enough
                               // for a diagnosis
  bool check_cameras = false;  // of rigs: warn of turned and of darker cameras
  /// Searches the pixels of a dense cloud, where it gives anything, in place of the CPU.
  std::function<std::unique_ptr<PixelSearch>()> pixel_search{};
};

struct IngestReport {
  CaptureLayout layout{};
  int64_t frames = 0, cameras = 0;
  int64_t points = 0;                 // size of the initial cloud that was found, 0 if none
  int64_t test_views = 0;             // of the splits test and val
  std::string scored;                 // what will be scored, in words (test_views.h)
  std::vector<std::string> warnings;  // one line each
  std::vector<std::string> notes;     // how the capture was read where that was a choice, likewise
  std::vector<CameraRow> camera_table;  // of rigs of clips; empty of others
};

/// Images with two possible layouts. The message names both and the option that decides.
class AmbiguousCapture : public InputError {
 public:
  using InputError::InputError;
};

/// Called with (what is being done, done, total); may throw to stop.
using IngestProgress = std::function<void(std::string_view, int64_t, int64_t)>;

/// The layout of the folder, by its files and by the stated layout of its images. Errors:
/// InputError naming what was looked for; AmbiguousCapture.
CaptureLayout detect_layout(const std::filesystem::path& capture,
                            std::optional<ImageLayout> image_layout = std::nullopt);

/// Errors: InputError naming an option whose value is none that it can have for any capture.
void check_values(const IngestOptions& options);

/// Reads `capture` and writes the prepared scene `out` (created; appears whole or not at all).
/// Errors: InputError, one line naming file and remedy.
IngestReport ingest_capture(const std::filesystem::path& capture, const std::filesystem::path& out,
                            const IngestOptions& options, const IngestProgress& progress);

/// Versions of the media libraries: {"FFmpeg", "5.1.6"}, …; empty in a trainer-only build.
std::vector<std::pair<std::string, std::string>> media_versions();

}  // namespace tessera
