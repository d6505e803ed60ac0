// Named sets of options: presets and ablations, and the properties of a scene that they depend on.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ingest/scene.h"
#include "recon4d/options/train_options.h"

namespace tessera {

using OptionOverrides = std::vector<std::pair<const char*, OptionValue>>;  // applied in order

/// `second` after `first`: of a key in both the later holds.
inline OptionOverrides joined(OptionOverrides first, const OptionOverrides& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

/// The properties of a scene that presets depend on.
struct SceneFacts {
  bool still = false;         // one timestep
  bool background = false;    // likewise, of what stands still in the clip of a rig
  int64_t camera_pixels = 0;  // of the distinct training cameras together; 0: not known
  int64_t views = 0;          // distinct training cameras; 0: not known
  int64_t images = 0;         // training images; 0: not known
  int64_t cameras = 0;        // that film at once: with half as many training frames as the longest
  int64_t timesteps = 0;      // training frames of the camera that has most
  double extent = 0;          // CameraRig::extent, world units
  bool single_view = false;   // several timesteps, of which none has two training views
  bool nodes = false;         // motion nodes are to carry it

  /// Several cameras that share timesteps, so that each timestep is seen from several sides.
  bool rig() const { return !still && cameras >= 3 && timesteps >= 3; }
};

/// Initial extents and learning rates of dynamic Gaussians that follow from the time between two
/// frames, not from the length of the clip.
struct FrameRates {
  double extent_frames = 0;   // initial temporal standard deviation; 0: none of the three applies
  double velocity_rate = 0;   // lr_velocity, scene extents a frame; 0: as elsewhere
  double mean_time_rate = 0;  // lr_mean_time, frames
};

/// What is seen in fewer photos, or frames of one camera, than kManyViews, or by fewer cameras of a
/// rig than kManyCameras, is soon fitted beyond what it shows.
inline constexpr int64_t kManyViews = 90, kStepsPerView = 300;
inline constexpr int64_t kManyCameras = 30, kStepsPerCamera = 1000;

inline constexpr int64_t kFewCameras = 4, kPixelsOfFewCameras = 16;

/// With fewer than these, what lies before a camera is fitted by the others
/// (recon4d/density/free_space.h, research/few_cameras.md).
inline constexpr int64_t kEnoughCameras = 8;

inline constexpr double kRigWeight = 0.1;
/// Of an image in which densify_threshold holds for static Gaussians as it is.
inline constexpr double kThresholdPixels = 1e6;

/// A set of options under a name: a preset on top of the defaults, an ablation on top of that.
struct NamedOptions {
  std::string name, doc;
  OptionOverrides overrides;
  OptionOverrides still_overrides = {};  // over those, where the scene has one timestep
  /// Of a scene of one timestep, or of one camera that nodes carry: whether iterations are at most
  /// kStepsPerView for each view, and less than kManyViews lower lr_sh_rest in proportion; of one
  /// timestep also gaussians_per_pixel, and raise opacity_weight and scale_weight.
  bool fits_to_views = false;
  /// Whether peak_gaussians is at most one for each kPixelsOfFewCameras pixels of kFewCameras
  /// cameras that film at once, for fewer pixels of more cameras in proportion; and of a rig,
  /// whether iterations are at most kStepsPerCamera for each camera, less than kManyCameras lower
  /// lr_sh_rest, opacity_weight and scale_weight are kRigWeight by its cameras, static_threshold
  /// grows as the side of its images falls below that of kThresholdPixels; with less than
  /// kEnoughCameras it has fewer steps for each, and clear_distance.
  bool fits_to_cameras = false;
  OptionOverrides rig_overrides = {};          // over the overrides, where SceneFacts::rig()
  FrameRates rig_rates = {};                   // likewise
  OptionOverrides single_view_overrides = {};  // likewise, where SceneFacts::single_view
  OptionOverrides node_overrides = {};         // over all of these, where SceneFacts::nodes
};
/// Options of a training. Where its motion is `auto`, `with_nodes` are those that hold once nodes
/// are chosen.
struct PlannedOptions {
  TrainOptions options;
  std::optional<TrainOptions> with_nodes;
};

/// Sets the options of the row `name` of a table. `kind`: "preset", for the message. Errors:
/// InputError naming the nearest known name.
void apply_named(TrainOptions& options, const std::vector<NamedOptions>& table, const char* kind,
                 const std::string& name, const SceneFacts& facts = {});

/// Of the training split; images need not be loaded.
SceneFacts facts_of(const Scene& scene);

/// Lowers peak_gaussians to so many, but not below 10,000; where it is 0, sets it.
void lower_limit(TrainOptions& options, int64_t gaussians);

using Preset = NamedOptions;
const std::vector<Preset>& presets();

/// Errors: InputError naming the nearest known name.
void apply_preset(TrainOptions& options, const std::string& name, const SceneFacts& facts = {});

/// Each technique taken out of the full method, and each added alone to a basis without any. An
/// ablation is applied on top of any preset.
using Ablation = NamedOptions;
const std::vector<Ablation>& ablations();

/// Errors: InputError naming the nearest known name.
void apply_ablation(TrainOptions& options, const std::string& name);

}  // namespace tessera
