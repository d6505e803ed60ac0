// What a training session knows before its first step: the scene, the options that its images have
// settled, the backend, the config.json, and the checkpoint of a training that is resumed.
#pragma once
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tools/session/clock/session_times.h"
#include "tools/session/device_choice.h"
#include "tools/session/static_model.h"
#include "tools/session/train_start.h"

namespace tessera {

struct TrainingSetup {
  std::optional<Checkpoint> previous;  // nothing: the training starts anew
  TrainOptions options;
  std::optional<TrainOptions> with_nodes;  // PlannedOptions::with_nodes
  Scene scene;
  std::optional<StaticModel> shared;  // whose static set the training leaves as it is
  std::unique_ptr<Backend> backend;
  DeviceChoice choice;
  nlohmann::json config;
  int64_t validation_views = 0;  // taken from the training split
  double motion_seconds = 0;     // of the trials of motion
  bool stopped = false;          // the observer stopped the trials: motion stays `auto`
};

/// Checkpoint and options of a request. Errors: as previous_state; InputError: invalid options.
TrainingSetup previous_setup(const TrainRequest& request, const RunFolder& run,
                             SessionObserver& observer);

/// Loads the scene, holds out validation views, chooses the backend and settles what the options
/// leave to the images. Trials of motion take at most a quarter of `seconds`; a resumed training
/// tries again where they were stopped. Errors: InputError, DeviceError; CheckpointRefused: the
/// checkpoint is of other frames.
void complete_setup(TrainingSetup& setup, const TrainRequest& request, const RunFolder& run,
                    double seconds, WallSplit& wall, SessionObserver& observer,
                    const std::function<void(const std::string&)>& warn);

}  // namespace tessera
