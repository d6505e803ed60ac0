// The start of motion nodes (positions by farthest-point sampling of the static set, radii by their
// neighbours, and a fixed binding of every Gaussian to its nearest nodes), and a larger number of
// control points whose spline follows the previous one as closely as possible. Source: [SC-GS].
#pragma once
#include <array>
#include <vector>

#include "recon4d/model/gaussian_set.h"
#include "recon4d/model/train_state.h"

namespace tessera {

/// How many nodes there are where nothing says otherwise, and how many for a scene of many limbs.
inline constexpr int64_t kFewNodes = 64, kManyNodes = 256;

/// Nodes of a set, at rest.
struct NodePlan {
  std::vector<Vec3<float>> position;  // [M] world units
  std::vector<float> log_radius;      // [M] ln of the distance to the third nearest node
  std::vector<float> node;            // [N, kBindings] nearest first; −1: none
};

/// At most `nodes`, and at most a quarter of those elements that may have one: more opaque than
/// 0.1, or among the 4 · `nodes` most opaque and more than 0.01, and no more than three times as
/// far from the centre as half of these are. Fewer where two would lie in one place. The first is
/// the one farthest from the centre. `mean`: [N, 3] world units; `opacity_logit`: [N].
NodePlan plan_nodes(Span<const float> mean, Span<const float> opacity_logit, int64_t nodes);

/// The static set of a state, where the backend works, becomes canonical: nodes at rest with
/// `knots` control points, logits 0. Nothing changes where no node is found.
void start_nodes(Backend& backend, const NodePlan& plan, int knots, TrainState& state);

/// Control points `knots` whose spline is the old one in the least-squares sense, exactly where
/// knots = 2·S − 3. `knots` is at least as large as before. Optimizer state is zero afterwards.
/// `step`: steps done. Nodes are in any memory.
void refit_nodes(int knots, int64_t step, MotionNodes& nodes);

}  // namespace tessera
