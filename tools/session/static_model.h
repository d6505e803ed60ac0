// The static set that all windows of a long clip share, with what else of its training they keep:
// how it is drawn, the colours of the training images, and the images of what stands still.
#pragma once
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "kernels/base/light_gain.h"
#include "recon4d/model/exposure.h"
#include "recon4d/model/gaussian_set.h"
#include "recon4d/options/train_options.h"
#include "recon4d/reduction/size_limit.h"

namespace tessera {

struct StaticModel {
  std::filesystem::path run;
  GaussianModel model;           // static Gaussians alone
  TrainOptions options;          // of its training, as it settled them
  nlohmann::json exposure;       // of exposure_json; null: nothing was learnt
  std::vector<Frame> stills;     // [cameras] of its scene, at the size of the training
  LightGain light = kSameLight;  // of a window, by that of the background; both are in it then
  // of training cameras, by `light`: as they expose for themselves
  std::map<std::string, LightGain> of_camera;
};

/// `run`: the folder of a finished training on a scene of `tessera unpack --static`. Errors:
/// InputError: another folder, a training of something else, a scene that is gone.
StaticModel load_static_model(const std::filesystem::path& run);

/// The options of a window become those of the static set where both must agree: how Gaussians are
/// drawn, the kind of colours of the training images; SH begins with all degrees, and the limit of
/// Gaussians while they grow is that of those beside it. Errors: InputError: options that change
/// static Gaussians, or frames of another scale or background.
void adopt_rules(const StaticModel& shared, TrainOptions& options);

/// Limits of size are those of the clip: what the static set leaves of one is shared by the `count`
/// windows, and the limit of a window has the static set beside its part. Errors: InputError: it
/// leaves nothing.
void share_limits(const StaticModel& shared, int64_t count, const ShippedBytes& shipped_bytes,
                  TrainOptions& options);

/// Errors: InputError: the static set is of another world than `scene`.
void check_world(const StaticModel& shared, const Scene& scene);

/// Brings images of what stands still into the light of the window `scene`, each by the median of
/// its camera's frames. Returns the factors of cameras that have frames with pixels.
std::map<std::string, LightGain> take_light(const Scene& scene, std::vector<Frame>& stills);

/// Puts the static set and its images into the light of the window `scene`: the mean of its
/// training cameras, by the medians of their frames. Where the light of a camera differs by more
/// than 0.03 from that, cameras get gains, if the static set has none.
void adopt_light(const Scene& scene, StaticModel& shared, TrainOptions& options);

/// The colours of the training images of `scene` as the static set has them, in the light of each
/// camera. Errors: InputError: a camera that it does not know.
LearntRows shared_exposure(const StaticModel& shared, const Scene& scene,
                           const TrainOptions& options);

/// Tells static sets apart: a hash of the model's file. Errors: InputError: as load_static_model.
std::string static_model_digest(const std::filesystem::path& run);

}  // namespace tessera
