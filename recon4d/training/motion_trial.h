// The choice between motion nodes and dynamic Gaussians for a capture, by short trainings at a
// small size and the frames that both hold out.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "ingest/scene.h"
#include "kernels/backend.h"
#include "recon4d/options/train_options.h"

namespace tessera {

struct MotionTrial {
  // of the frames held out, dB; frozen: with nodes, all frames at the middle of the clip
  double nodes_psnr = 0, dynamic_psnr = 0, frozen_psnr = 0;
  std::optional<double> many_nodes_psnr;  // with kManyNodes, where nodes are preferred
  int64_t frames = 0;                     // held out

  /// Whether what nodes carry moves: a still scene is drawn as well with its motion taken away.
  bool nodes_move() const { return nodes_psnr > frozen_psnr + 0.1; }
  bool prefers_nodes() const { return nodes_psnr > dynamic_psnr && nodes_move(); }
  /// Many limbs need many nodes; elsewhere these fit noise in longer trainings.
  bool prefers_many_nodes() const { return many_nodes_psnr.value_or(0) > nodes_psnr + 0.3; }
};

/// The reason why a trial cannot decide; empty: it can. Nodes are for scenes of one view a
/// timestep; a trial needs frames to hold out, and a training that is long beside it.
std::string reason_against_trial(const Scene& scene, const TrainOptions& options);

/// Trains twice and scores, and a third time, with kManyNodes, where nodes are preferred and their
/// number is not stated. Frames of Split::kValidation are those held out; without any a share of
/// the training frames is. `with_nodes`: options of the training where nodes carry the scene.
/// Nothing where `stop`, called before each step, returned true.
std::optional<MotionTrial> try_motion(Backend& backend, const Scene& scene,
                                      const TrainOptions& with_nodes,
                                      const std::function<bool()>& stop);

}  // namespace tessera
