// The ground truth of a capture: ground_truth.json, masks of what changes, and static surface
// points. Ingest and training do not read it; tests and measurements do.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "tools/synth/render.h"
#include "tools/synth/world.h"

namespace tessera::synth {

constexpr const char* kTruthFile = "ground_truth.json";
constexpr const char* kTruthFolder = "ground_truth";
/// Masks named as the frames, of scenes with a stated moving region (ever_covered).
constexpr const char* kMovingFolder = "ground_truth/moving";

/// A camera of the capture. Video: it sees every instant; dnerf: one image, so split, index and
/// time say which.
struct TrueView {
  std::string name;  // "cam00", or "train/r_000"
  Camera camera;
  std::string split;  // empty for video
  int index = 0;      // within the split
  double time = 0;    // normalised; dnerf only
  /// By name of a solid that moves, one a frame, empty where the camera does not see it. Video
  /// only.
  std::map<std::string, std::vector<PixelBox>> boxes = {};
};

/// Instant `frame` of a clip, normalised to [0, 1] (0 for a clip of one frame).
double normalised_time(const SynthOptions& options, double frame);
/// The time of the world, 0 to 1, that a frame shows: that of the clip, or of its repeated part.
double world_time(const SynthOptions& options, double frame);
/// Whether the share of the image in which anything moves is an option of the scene.
inline bool has_moving_region(const SynthOptions& options) {
  return options.scene == SynthScene::kPatch;
}
/// Frames by which that camera records later than its timestamps.
double shift_of(const SynthOptions& options, int camera);
/// Frames by which its bottom row is exposed later than its top one.
double readout_of(const SynthOptions& options, int camera);
/// Normalised time to seconds from the first frame.
double seconds(const SynthOptions& options, double normalised);

/// What the solids that come and go, the views and the options are, as ground_truth.json.
std::string truth_json(const SynthOptions& options, const World& world,
                       const std::vector<TrueView>& views);

/// `count` points on static surfaces, each seen by some view at t = 0 if nothing moving hid it;
/// fewer where most rays meet nothing.
PointCloud sample_static_points(const World& world, const std::vector<TrueView>& views, int count,
                                uint64_t seed);
/// Columns x y z red green blue.
void write_points(const std::filesystem::path& path, const PointCloud& points);

/// [height, width] 1 where a sample meets something that changes at one of `times` (normalised).
std::vector<uint8_t> ever_covered(const World& world, const Camera& camera,
                                  const std::vector<double>& times, const StaticLayer& layer);

/// Grey: 0 what never changes in this camera, else 128 + 127 · the share of the pixel's samples
/// that meet something that changes at the image's own timestep. `ever`: as by ever_covered.
Image8 moving_image(const RenderedImage& image, const std::vector<uint8_t>& ever);

/// The instants of a clip, normalised.
std::vector<double> clip_times(const SynthOptions& options);

}  // namespace tessera::synth
