// The description of a prepared scene (ARCHITECTURE.md, "The prepared scene") and its writer.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/poses/lens.h"
#include "ingest/scene.h"
#include "ingest/video/frame_timing.h"

namespace tessera {

struct PreparedFrame {
  std::string file_path;         // below the scene's folder, with extension
  Frame frame;                   // its pixels are not used
  std::optional<int64_t> ticks;  // presentation time in the camera's time base (videos)
  std::string mask_path;         // below the scene's folder; empty: all pixels are used
};

/// A lens whose distortion was taken out of the images.
struct RemovedLens {
  std::string model;  // COLMAP's or Nerfstudio's name: "OPENCV"
  Lens lens;
};

struct PreparedCamera {
  std::string name;
  Rational time_base{};         // seconds a tick
  double time_offset = 0;       // seconds added to the camera's own clock
  double time_uncertainty = 0;  // its standard error, seconds
  double time_measured = 0;     // what was measured, of which time_offset keeps what is certain
  std::string time_source{};    // where the offset comes from: "motion", "audio", …; empty: none
  std::vector<RemovedLens> removed_lenses{};             // distinct; several where it was zoomed
  std::optional<std::array<double, 3>> exposure_gain{};  // R G B its images were divided by
};

struct SourceFile {
  std::string name;  // relative to the capture
  std::string hash;  // source_hash()
};

struct PreparedScene {
  std::string layout;             // "transforms", "n3dv", "colmap", "llff"
  std::string background;         // what was done about alpha: "alpha kept", "opaque"
  bool inverted_masks = false;    // masks had black for used pixels; those written never have
  std::string tone_map = "none";  // of linear images, HLG, PQ and BT.2020 videos
  double scale = 1;               // prepared size by source size
  TimeAxis time_axis;
  Similarity prepared_from_source;  // poses and points here are in the prepared world
  Rational time_base;  // seconds a tick of the first camera; 1/1 where times were stated
  bool is_static = false;
  bool has_points = false;  // points.ply lies beside transforms.json
  std::vector<PreparedFrame> frames;
  std::vector<PreparedCamera> cameras;
  std::vector<SourceFile> sources;
};

/// Notes that `camera` took an image through `lens`, which was removed; a pinhole is nothing.
void note_removed_lens(PreparedCamera& camera, const RemovedLens& removed);

/// Writes `folder`/transforms.json. Errors: InputError when it cannot be written.
void write_prepared_scene(const std::filesystem::path& folder, const PreparedScene& scene);

}  // namespace tessera
