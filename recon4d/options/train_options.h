// All options of a training as plain data, and the table that names, documents and bounds each of
// them. The command line, --config, --help and checkpoint metadata are made from this table.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "kernels/batch.h"
#include "kernels/drawing_rules.h"
#include "kernels/gaussians.h"
#include "recon4d/options/choices.h"
#include "recon4d/options/option_value.h"

namespace tessera {

/// The drawing rules are those of the finished model. Grouped by meaning, not by size.
struct TrainOptions : DrawingRules {  // NOLINT(clang-analyzer-optin.performance.Padding)
  TrainOptions() {
    far_plane = 100;
    sh_time_degree = 0;
  }

  // steps
  int64_t iterations = 30000, schedule_iterations = 30000, batch = 4, seed = 1;
  // scene
  Motion motion = Motion::kPair;
  std::string background = "black";
  double train_scale = 1;
  // initial Gaussians
  int64_t init_points = 100000;
  double init_extent = 0, init_opacity = 0.1, init_scale_factor = 1;
  double init_time_scale = 0.4472135955, static_fraction = 0;
  bool carve = true, sweep = false, split_by_motion = false;
  // validation frames, by which the model is chosen
  double validation_share = 0;
  int64_t validate_interval = 500, stop_patience = 0;
  // colour
  int64_t sh_interval = 1000;
  // aliasing
  Filter3d filter_3d = Filter3d::kNone;
  // loss
  double lambda_dssim = 0.2, moving_weight = 0, opacity_weight = 0, scale_weight = 0, noise = 0;
  // environment
  bool environment = false;
  int64_t environment_size = 256;
  double lr_environment = 2.5e-3;
  // exposure of the training images
  ExposureGains exposure = ExposureGains::kNone;
  double lr_exposure = 0.01;
  // clocks and shutters of the training cameras
  Clocks clocks = Clocks::kFixed;
  bool learn_readouts = false;
  double lr_clocks = 0.01;
  // learning rates
  double lr_mean = 1.6e-4, lr_mean_final = 1.6e-6;
  double lr_mean_time = 1.6e-4;
  double lr_scale = 5e-3, lr_scale_time = 5e-3, lr_rotation = 1e-3, lr_velocity = 5e-4;
  double lr_opacity = 0.05, lr_sh = 2.5e-3, lr_sh_rest = 1.25e-4;
  double average_from = 0;
  bool fused_optimizer = true;
  IdleUpdate idle_updates = IdleUpdate::kDense;
  // density control
  Densification densification = Densification::kAdc;
  GrowthPart budget_without = GrowthPart::kNone;
  int64_t densify_from = 600, densify_until = 14900, densify_interval = 100;
  double densify_threshold = 2e-4, static_threshold = 1, dense_fraction = 0.01;
  bool static_halves = false;
  double prune_opacity = 0.005, prune_extent = 0.1;
  int64_t prune_large_from = 3000, opacity_reset_interval = 0, max_gaussians = 0;
  int64_t reorder_interval = 5000;
  double min_blending_weight = 0, clear_distance = 0;
  int64_t unseen_interval = 500;
  // motion nodes, of Motion::kNodes
  int64_t motion_nodes = 0, nodes_from = 1300, node_knots = 100, node_knot_interval = 1500;
  double lr_node_translation = 1e-3, lr_node_rotation = 5e-3, lr_node_decay = 0.004;
  double lr_node_logit = 0.01, lr_node_radius = 0.01, node_acceleration = 1e-5;
  double mcmc_noise = 5e5, mcmc_growth = 1.05;
  // no more than the scene needs (docs/explanation/size.md)
  ModelSize size = ModelSize::kGrown;
  int64_t peak_gaussians = 0, max_bytes = 0;
  double gaussians_per_pixel = 0;
  double within_db = 0;
  int64_t thin_rounds = 4, thin_until = 25000;
  bool decide_motion = false, decide_colour = false, spawn_missed = false;
  int64_t decide_interval = 3000;
  // how kernels work (KernelSwitches); none changes what is drawn
  bool rectangular_bounds = true, opacity_bounds = true;
  bool balanced_instances = true, separate_sort = true, warp_culling = true;
  BackwardForm backward = BackwardForm::kSubTile;
  bool deterministic = false;
  int64_t feed_bytes = 0;
};

/// An option of an enumeration, by the names of its values.
struct ChoiceMember {
  std::vector<const char*> names;
  size_t (*get)(const TrainOptions&);
  void (*set)(TrainOptions&, size_t);
};

/// One option of a training. The command line, --help, --config, the reference pages, man pages,
/// shell completion and the metadata of checkpoints are made from these rows.
struct TrainOption {
  const char* key;  // snake_case in JSON, dashes on the command line
  std::variant<int64_t TrainOptions::*, int TrainOptions::*, double TrainOptions::*,
               bool TrainOptions::*, std::string TrainOptions::*, ChoiceMember>
      member;
  double low = 0, high = 0;  // numbers: inclusive range
  const char* doc;           // one line: meaning and unit
  const char* source;        // of the default
  const char* group;         // heading in --help-all and the reference
  Unit unit = Unit::kNone;   // of numbers: which suffixes text may have
  const char* example = "";  // a value, for --help; empty: none

  /// Allowed values of a choice; empty for other options.
  std::vector<const char*> choices() const;
  bool is_switch() const { return std::holds_alternative<bool TrainOptions::*>(member); }
};
const std::vector<TrainOption>& train_option_table();

/// Sets one option by key, from its value or from text. Errors: InputError: unknown key (nearest
/// named), wrong type, out of range.
void set_option(TrainOptions& options, const std::string& key, const OptionValue& value);
void set_option_from_text(TrainOptions& options, const std::string& key, const std::string& text);
OptionValue option_value(const TrainOptions& options, const TrainOption& option);
/// Checks conditions between options. Errors: InputError.
void validate(const TrainOptions& options);

/// Most Gaussians while they grow; 0: no limit.
int64_t growth_limit(const TrainOptions& options);
/// Whether Gaussians grow with that part of densification budget.
bool grows_with(const TrainOptions& options, GrowthPart part);
/// Whether Gaussians are pruned after growth.
bool prunes_after_growth(const TrainOptions& options);

/// "black", "white", or "r,g,b" in 0–255. Errors: InputError.
std::array<uint8_t, 3> parse_background(const std::string& text);

KernelSwitches kernel_switches(const TrainOptions& options);
/// Of the dynamic set.
SetForm dynamic_form(const TrainOptions& options);

}  // namespace tessera
