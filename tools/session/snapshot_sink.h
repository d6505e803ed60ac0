// Who wants to see the model while it trains, and is handed it between two steps.
#pragma once
#include "ingest/scene.h"
#include "recon4d/model/train_state.h"

namespace tessera {

class SnapshotSink {
 public:
  virtual ~SnapshotSink() = default;
  /// Once, before the first step. Images of `scene` are in memory; nothing of it is kept.
  virtual void begin(const Scene& scene, const TrainOptions& options) = 0;
  /// Asked before each step: whether the training is to stop for take().
  virtual bool due() = 0;
  /// `state` is in the backend's memory, and changes after the call.
  virtual void take(const TrainState& state) = 0;
};

}  // namespace tessera
