// The tables of scenes and layouts, the checks of options, and make_capture, which fills a
// temporary folder and then moves it to `out`.
#include "tools/synth/synth.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "kernels/base/errors.h"
#include "tools/synth/ground_truth.h"
#include "tools/synth/layouts.h"
#include "tools/synth/world.h"
#include "tools/video/video_encoder.h"

namespace tessera {
namespace {

constexpr std::array<SynthSceneRow, 6> kScenes{{
    {SynthScene::kRoom, "room",
     "furnished room: rigid, stretching and waving movers, an object that comes and goes"},
    {SynthScene::kRoomStatic, "room-static",
     "the same room as at its first instant, without the object that comes and goes"},
    {SynthScene::kObject, "object",
     "a moving, deforming toy on nothing (transparent), seen from an upper hemisphere"},
    {SynthScene::kPatch, "patch",
     "the furnished room where nothing moves but a ball in a given share of the image"},
    {SynthScene::kFigure, "figure",
     "a marching figure with skirt and scarf on nothing (transparent), seen from all around"},
    {SynthScene::kFast, "fast",
     "the furnished room with fast movers: two thrown balls, a swinging arm, a waving flag"},
}};

constexpr std::array<SynthLayoutRow, 3> kLayouts{{
    {SynthLayout::kDnerf, "dnerf", "monocular D-NeRF folder: transforms_*.json and RGBA PNGs"},
    {SynthLayout::kN3dv, "n3dv", "one mp4 per camera and poses_bounds.npy, cam00 in the middle"},
    {SynthLayout::kVideos, "videos", "one mp4 per camera, no poses"},
}};

void check_range(const char* name, double value, double least, double most) {
  if (value >= least && value <= most) return;  // false for NaN
  throw InputError(
      fmt::format("synth: {} is {}; give a value from {} to {}", name, value, least, most));
}

/// Values by camera of an option. A camera's frames lie within a clip's length of the clip, where
/// the motion is defined.
void check_frames(const SynthOptions& options, const char* name,
                  const std::vector<double>& frames) {
  if (frames.empty()) return;
  if (options.layout == SynthLayout::kDnerf)
    throw InputError(
        fmt::format("synth: the layout dnerf has one camera, whose images have one time each; "
                    "leave out --{} or use the layout n3dv or videos",
                    name));
  if (frames.size() > size_t(options.cameras))
    throw InputError(
        fmt::format("synth: --{} names cam{:02}, but the cameras are cam00 to "
                    "cam{:02}; name one of these or raise --cameras",
                    name, frames.size() - 1, options.cameras - 1));
  for (const double value : frames)
    if (!(std::abs(value) < std::max(1, options.frames - 1)))
      throw InputError(fmt::format("synth: a {} is {} frames; give less than the clip's {}", name,
                                   value, options.frames - 1));
}

/// The light and the gains of cameras are those of a rig.
void check_light_and_gains(const SynthOptions& options) {
  check_range("light_step", options.light_step, kLeastLightStep, kMostLightStep);
  if (options.layout != SynthLayout::kDnerf) return;
  for (const auto& [given, name] : {std::pair{options.light_step != 1, "--light-step"},
                                    {options.camera_gains, "--camera-gains"}})
    if (given)
      throw InputError(
          fmt::format("synth: the layout dnerf has no rig of cameras; leave out {} or use the "
                      "layout n3dv or videos",
                      name));
}

/// Fills in the share of a scene that has a moving region, refuses one for the others.
void resolve_moving_share(SynthOptions& options) {
  constexpr double kUsual = 0.05;
  if (options.scene == SynthScene::kPatch) {
    if (options.moving_share == 0) options.moving_share = kUsual;
    check_range("moving_share", options.moving_share, kLeastMovingShare, kMostMovingShare);
  } else if (options.moving_share != 0) {
    throw InputError(
        fmt::format("synth: the scene {} has no moving region of a given size; leave out "
                    "--moving-share or use the scene patch",
                    name_of(options.scene)));
  }
}

}  // namespace

bool is_made_capture(const std::filesystem::path& folder) {
  std::error_code ignored;  // a folder that cannot be read is refused by StagedFolder
  return std::filesystem::exists(folder / synth::kTruthFile, ignored);
}

SynthReport make_capture(const SynthOptions& options, const std::filesystem::path& out,
                         const SynthProgress& progress) {
  const SynthOptions full = resolve_synth_options(options);
  if (out.empty()) throw InputError("synth: the output has no name; name a folder");
  const synth::World world =
      synth::build_world(full.scene, full.seed, full.specular,
                         full.scene == SynthScene::kPatch ? synth::patch_radius(full) : 0);
  StagedFolder pending(out, is_made_capture(out));
  make_folder(pending.path() / synth::kTruthFolder);

  const bool dnerf = full.layout == SynthLayout::kDnerf;
  const synth::CaptureJob job{full, world, pending.path(), progress};
  const std::vector<synth::TrueView> views =
      dnerf ? synth::write_dnerf(job) : synth::write_videos(job);

  const PointCloud points = synth::sample_static_points(world, views, full.points, full.seed);
  synth::write_points(pending.path() / synth::kTruthFolder / "points.ply", points);
  write_text_file(pending.path() / synth::kTruthFile, synth::truth_json(full, world, views));
  pending.commit();

  SynthReport report;
  report.cameras = dnerf ? 1 : full.cameras;
  report.images = dnerf ? int64_t(views.size()) : int64_t(full.cameras) * full.frames;
  report.points = int64_t(points.position.size());
  return report;
}

std::span<const SynthSceneRow> synth_scenes() {
  return kScenes;
}
std::span<const SynthLayoutRow> synth_layouts() {
  return kLayouts;
}

std::string_view name_of(SynthScene scene) {
  return kScenes[size_t(scene)].name;
}
std::string_view name_of(SynthLayout layout) {
  return kLayouts[size_t(layout)].name;
}

std::optional<SynthScene> find_synth_scene(std::string_view name) {
  for (const SynthSceneRow& row : kScenes)
    if (row.name == name) return row.scene;
  return std::nullopt;
}

std::optional<SynthLayout> find_synth_layout(std::string_view name) {
  for (const SynthLayoutRow& row : kLayouts)
    if (row.name == name) return row.layout;
  return std::nullopt;
}

SynthOptions resolve_synth_options(const SynthOptions& options) {
  SynthOptions full = options;
  const bool dnerf = options.layout == SynthLayout::kDnerf;
  const bool square = dnerf && is_on_nothing(options.scene);
  if (full.width == 0) full.width = square ? 200 : 240;
  if (full.height == 0) full.height = square ? 200 : 180;
  check_range("cameras", full.cameras, 1, 100);
  check_range("frames", full.frames, 1, 100000);
  check_range("repeat", full.repeat, 0, 100000);
  if (full.repeat == 1 || (dnerf && full.repeat > 0))
    throw InputError("synth: --repeat takes two instants or more, of the layouts n3dv and videos");
  check_range("held_out_frames", full.held_out_frames, 0, 10000);
  check_range("width", full.width, 16, 8192);
  check_range("height", full.height, 16, 8192);
  check_range("fps numerator", full.fps.numerator, 1, 1e6);
  check_range("fps denominator", full.fps.denominator, 1, 1e6);
  check_range("supersampling", full.supersampling, 1, 16);
  check_range("specular", full.specular, 0, 1);
  check_range("video_quality", full.video_quality, 0, 51);
  check_range("noise_sigma", full.noise_sigma, 0, 64);
  check_range("exposure_wobble", full.exposure_wobble, 0, 0.5);
  check_range("points", full.points, 0, 1e7);
  check_frames(full, "shift", full.shifts);
  check_frames(full, "readout", full.readouts);
  check_light_and_gains(full);
  resolve_moving_share(full);
  if (full.held_out_frames == 0) full.held_out_frames = std::max(4, full.frames / 5);
  if (!dnerf && (full.width % 2 != 0 || full.height % 2 != 0))
    throw InputError(
        fmt::format("synth: {} x {} is odd, which 4:2:0 video cannot hold; give even "
                    "sizes or the layout dnerf",
                    full.width, full.height));
  if (!dnerf && !video_encoder_available())
    throw InputError(
        fmt::format("synth: this build has no video encoder (FFmpeg), which the layout "
                    "{} needs; use the layout dnerf or build with TESSERA_INGEST=ON",
                    name_of(full.layout)));
  return full;
}

}  // namespace tessera
