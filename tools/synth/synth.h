// Makes a textured dynamic capture with exact cameras and ground truth from a seed: options in, a
// folder on disk out. The other headers of this folder are internal.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "tools/video/frame_rate.h"

namespace tessera {

enum class SynthScene { kRoom, kRoomStatic, kObject, kPatch, kFigure, kFast };
enum class SynthLayout { kDnerf, kN3dv, kVideos };

/// One choice of the command line: its name and one line of explanation.
struct SynthSceneRow {
  SynthScene scene;
  std::string_view name, doc;
};
struct SynthLayoutRow {
  SynthLayout layout;
  std::string_view name, doc;
};
/// Whether rays that miss the solids of the scene meet no background.
inline bool is_on_nothing(SynthScene scene) {
  return scene == SynthScene::kObject || scene == SynthScene::kFigure;
}
std::span<const SynthSceneRow> synth_scenes();
std::span<const SynthLayoutRow> synth_layouts();
std::string_view name_of(SynthScene scene);
std::string_view name_of(SynthLayout layout);
std::optional<SynthScene> find_synth_scene(std::string_view name);
std::optional<SynthLayout> find_synth_layout(std::string_view name);

struct SynthOptions {
  SynthScene scene = SynthScene::kRoom;
  SynthLayout layout = SynthLayout::kN3dv;
  int cameras = 12;         // n3dv, videos; a dnerf capture is monocular and ignores it
  int frames = 24;          // instants; in dnerf the number of training views
  int repeat = 0;           // n3dv, videos: instants after which all moves back, and then again, so
                            // that a long clip moves as fast as a short one; 0: as the clip has
  int held_out_frames = 0;  // dnerf: views in each of val and test; 0: a fifth of frames, >= 4
  int width = 0, height = 0;  // pixels; 0: 240 × 180, or 200 × 200 on nothing as dnerf
  FrameRate fps;
  uint64_t seed = 1;           // textures, colours, small offsets of furniture and cameras
  int supersampling = 3;       // N × N rays a pixel, 1..16; 16·N² bytes of memory a pixel
  double specular = 0;         // strength of a highlight in [0, 1]; 0: no view dependence
  int video_quality = 8;       // x264 crf, 0 (lossless) .. 51
  double noise_sigma = 0;      // of each channel, in levels of 255
  double exposure_wobble = 0;  // largest relative change of a frame's gain, [0, 0.5]: 0.01 is 1 %;
                               // the reference (cam00 of a rig, dnerf's val and test) has none
  double light_step = 1;       // n3dv, videos: factor of the light from the middle of the clip on,
                               // kLeastLightStep .. kMostLightStep
  bool camera_gains = false;   // n3dv, videos: every camera but cam00 has gains of red, green and
                               // blue in [0.8, 1.2), by the seed
  double moving_share = 0;     // `patch`: share of cam00's image in which something ever moves,
                               // kLeastMovingShare .. kMostMovingShare; 0: 0.05
  int points = 20000;          // size of ground_truth/points.ply
  std::vector<double> shifts;  // n3dv, videos, frames by camera number, 0 for those not listed:
                               // frame k of the camera shows instant k + shift
  std::vector<double> readouts;  // n3dv, videos, frames by camera number, likewise: by how much
                                 // later the bottom row is exposed than the top one
};

inline constexpr double kLeastMovingShare = 0.005, kMostMovingShare = 0.3;
inline constexpr double kLeastLightStep = 0.25, kMostLightStep = 4;

struct SynthReport {
  int64_t cameras = 0;  // physical cameras: 1 for dnerf
  int64_t images = 0;   // images rendered, over all cameras or splits
  int64_t points = 0;   // static surface points written
};

/// Called with (what is being done, done, total); may throw to stop.
using SynthProgress = std::function<void(std::string_view, int64_t, int64_t)>;

/// Whether the folder is a capture that make_capture has written: it has a ground_truth.json.
bool is_made_capture(const std::filesystem::path& folder);

/// Renders the capture and writes it as the folder `out`, which appears whole or not at all. A made
/// capture that is there is replaced. Errors: InputError, one line with the remedy:
/// an option out of range, odd size of a video, no video encoder in this build, `out` exists and is
/// not ours, cannot be written.
SynthReport make_capture(const SynthOptions& options, const std::filesystem::path& out,
                         const SynthProgress& progress);

/// `options` with sizes and counts that were left at 0 filled in. Errors: InputError as above.
SynthOptions resolve_synth_options(const SynthOptions& options);

}  // namespace tessera
