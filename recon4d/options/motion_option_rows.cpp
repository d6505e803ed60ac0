// Options of motion nodes, which carry one set of Gaussians through the clip.
#include "recon4d/options/option_rows.h"

namespace tessera {

void OptionRows::add_motion() {
  group("Motion nodes");
  number("motion_nodes", &O::motion_nodes, {0, 1024, Unit::kCount}, "ours; [SC-GS] has 512",
         "Largest number of motion nodes, of --motion nodes; 0: 64, and 256 where --motion auto "
         "has shown that more of them show more");
  number("nodes_from", &O::nodes_from, kSteps, "ours",
         "Step at which motion starts; until then the scene is static");
  number("node_knots", &O::node_knots, {5, 256}, "ours",
         "Largest number of control points of a node; they begin with 5, then nearly double, and "
         "are at most one for four timesteps");
  number("node_knot_interval", &O::node_knot_interval, kPositiveSteps, "ours",
         "Steps after which nodes get more control points");
  number("lr_node_translation", &O::lr_node_translation, kRate, "ours",
         "Learning rate of the control points of translation at the start, per scene extent");
  number("lr_node_rotation", &O::lr_node_rotation, kRate, "ours",
         "Learning rate of the control points of rotation at the start");
  number("lr_node_decay", &O::lr_node_decay, {1e-6, 1}, "ours",
         "Factor by which the learning rates of control points have fallen at the end");
  number("lr_node_logit", &O::lr_node_logit, kRate, "ours",
         "Learning rate of the logits by which Gaussians weigh their nodes");
  number("lr_node_radius", &O::lr_node_radius, kRate, "ours",
         "Learning rate of log radii of nodes");
  number("node_acceleration", &O::node_acceleration, kWeight, "ours",
         "Weight of the squared second differences of control points of translation, at 25 of "
         "them; S of them have the (S / 25)^3-fold weight");
}

}  // namespace tessera
