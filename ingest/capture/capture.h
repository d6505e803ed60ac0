// A capture as a value: its cameras, its frames and where their pixels are, its points. A reader of
// a layout makes one, every step of `ingest` takes and returns one, and the prepared scene is
// written from it.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/camera_row.h"
#include "ingest/poses/intrinsics.h"
#include "ingest/poses/pinhole_view.h"
#include "ingest/scene.h"
#include "ingest/video/clip.h"

namespace tessera {

/// A lens whose distortion was taken out of the images.
struct RemovedLens {
  std::string model;  // COLMAP's or Nerfstudio's name: "OPENCV"
  Lens lens;
};

struct CaptureCamera {
  std::string name;
  Rational time_base{};         // seconds a tick
  double time_offset = 0;       // seconds added to the camera's own clock
  double time_uncertainty = 0;  // its standard error, seconds
  double time_measured = 0;     // what was measured, of which time_offset keeps what is certain
  std::string time_source{};    // where the offset comes from: "motion", "audio", …; empty: none
  std::vector<RemovedLens> removed_lenses{};             // distinct; several where it was zoomed
  std::optional<std::array<double, 3>> exposure_gain{};  // R G B its images were divided by
};

/// How an image file was taken, beyond its pose.
struct StatedView {
  /// For an image of any size; absent where Frame::camera has a size and intrinsics.
  std::optional<StatedIntrinsics> intrinsics;
  Lens lens;
  std::string lens_model = "PINHOLE";
  std::string where;  // "transforms.json, frame 3 (r_3.png)", for messages
};

struct SourceFile {
  std::string name;  // relative to the capture
  std::string hash;  // source_hash()
};

struct CaptureFrame {
  /// Without pixels. Its time is in the capture's unit until set_times(), its camera that of the
  /// image as stored until write_images().
  Frame frame;
  std::filesystem::path image;   // empty: decoded from the clip of its camera, or not there
  std::filesystem::path mask;    // black: ignored; empty: all pixels are used
  std::string image_name;        // as the layout names it, with extension; empty of clips
  SourceFile source;             // the image; without name: its clip is the source
  int64_t view = -1;             // of Capture::views; −1: its clip has the camera
  std::optional<int64_t> ticks;  // presentation time in the camera's time base (clips)
  std::string file_path;         // of the written image, below the scene's folder
  std::string mask_path;         // of the written mask, likewise; empty: all pixels are used
  FieldOfView field_of_view = FieldOfView::kValid;  // of the written image
};

struct Capture {
  std::filesystem::path folder;
  std::string layout;  // "transforms", "n3dv", "colmap", …, as the prepared scene states it

  std::vector<RigClip> clips;        // recordings, one a camera, by name; empty of image files
  std::vector<char> held_out;        // one a clip, once that is chosen
  std::vector<std::string> partial;  // names of clips that film a part of the time that is kept
  std::filesystem::path photos;      // the folder of a photo set; empty of others
  bool posed = true;                 // every clip or frame has a pose
  std::string unused_poses;          // why poses that lie there are not used; may be empty
  std::vector<CaptureCamera> cameras;
  std::vector<StatedView> views;
  std::vector<CaptureFrame> frames;
  int64_t test_every = 0;  // images 0, N, 2N … are the test split by default; 0: none

  bool is_timed = false;                     // frames state times; otherwise the scene stands still
  std::filesystem::path times_from;          // what states them, for messages
  std::optional<TimeAxis> stated_axis;       // the times are normalised already, on this axis
  std::optional<std::string> points_file{};  // find_points() with it; absent: `points` is all
  std::optional<TimeAxis> points_axis;       // of the times of these points, if not time_axis
  glm::dvec3 origin{0};                      // taken out of all poses and points
  PointCloud points;                         // in the world of the poses
  std::vector<std::pair<std::string, std::filesystem::path>> files;  // read beside the images:
                                                                     // names among sources, paths
  std::vector<std::string> warnings;                                 // one line each
  std::vector<std::string> notes;       // how the capture was read where that was a choice
  std::vector<CameraRow> camera_table;  // of several clips, in the end

  // What was done, as the prepared scene states it.
  std::string background = "opaque";  // what was done about alpha: "alpha kept", "opaque"
  bool inverted_masks = false;        // masks had black for used pixels; those written never have
  std::string tone_map = "none";      // of linear images, HLG, PQ and BT.2020 videos
  double scale = 1;                   // prepared size by source size
  TimeAxis time_axis;
  Similarity prepared_from_source;  // poses and points here are in the prepared world
  Rational time_base;               // seconds a tick of the first camera; 1/1: times were stated
  bool is_static = false;
  bool has_points = false;  // points.ply lies beside transforms.json
  std::vector<SourceFile> sources;
  bool by_reference = false;  // frames stay in the clips, which transforms.json describes
};

/// Takes the far_origin() of all poses, which are stated, out of them, beside `origin` that was
/// taken out already.
void take_origin_out(Capture& capture);

std::vector<std::string> clip_names(const Capture& capture);
/// Leaves clips out, all entries alike; `keep` has one entry a clip.
void keep_clips(Capture& capture, const std::vector<char>& keep);

/// Notes that `camera` took an image through `lens`, which was removed; a pinhole is nothing.
void note_removed_lens(CaptureCamera& camera, const RemovedLens& removed);

/// One warning that lists `missing` images, which `owner` ("the COLMAP model") names. Errors:
/// InputError with the same text under `strict`.
void note_missing(const std::filesystem::path& folder, const std::vector<std::string>& missing,
                  const std::string& owner, bool strict, std::vector<std::string>& warnings);

}  // namespace tessera
