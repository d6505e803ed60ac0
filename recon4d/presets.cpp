// What: named sets of options, as data rows.
// Not: code paths: a preset only changes what any user could set by hand.
#include "recon4d/train_options.h"

namespace tessera {

namespace {

using Overrides = decltype(Preset::overrides);

/// `more` after `base`: of a key in both the later holds.
Overrides with(Overrides base, const Overrides& more) {
  base.insert(base.end(), more.begin(), more.end());
  return base;
}

/// Half of what is not known to move starts static, moments are free to move.
const Overrides kBalanced = {{"iterations", 7000},      {"motion_form", "velocity"},
                             {"static_fraction", 0.5},  {"lr_mean_time", 2e-3},
                             {"idle_updates", "lazy"},  {"init_points", 50000},
                             {"max_gaussians", 400000}, {"sweep", true},
                             {"split_by_motion", true}};
/// The chain's own settings  [3DGS-MCMC].
const Overrides kMcmc = {{"densification", "mcmc"},
                         {"densify_until", 24900},
                         {"opacity_weight", 0.01},
                         {"scale_weight", 0.01},
                         {"init_opacity", 0.5}};

}  // namespace

const std::vector<Preset>& presets() {
  static const std::vector<Preset> rows = {
      {"fast",
       "minutes on a CPU: few initial points, short schedule",
       {{"iterations", 2000},
        {"schedule_iterations", 30000},
        {"init_points", 20000},
        {"max_gaussians", 40000},
        {"sweep", true},
        {"split_by_motion", true}}},
      {"balanced",
       "the default: half of what is not known to move starts static, velocities, 7,000 steps",
       kBalanced},
      {"best", "balanced as a Markov chain of 200,000 Gaussians",
       with(with(kBalanced, kMcmc), {{"max_gaussians", 200000}})},
      {"faster-gs",
       "the 4D protocol of Faster-GS: all dynamic, batch 4, opacity reset every 3000 steps",
       {{"opacity_reset_interval", 3000}, {"idle_updates", "lazy"}}},
      {"yang4d",
       "Yang's N3DV protocol with plain SH: opacity reset every 3000 steps, no carving",
       {{"opacity_reset_interval", 3000}, {"carve", false}}},
      {"3dgs",
       "static 3DGS: one view a step, opacity reset, one timestep",
       {{"static_only", true},
        {"idle_updates", "lazy"},
        {"batch", 1},
        {"lr_opacity", 0.025},
        {"opacity_reset_interval", 3000},
        {"far_plane", 1e4}}},
      {"mcmc", "static 3DGS as a Markov chain: exactly max_gaussians, no opacity reset",
       with(kMcmc, {{"static_only", true},
                    {"idle_updates", "lazy"},
                    {"batch", 1},
                    {"far_plane", 1e4},
                    {"lr_opacity", 0.05},
                    {"max_gaussians", 1000000},
                    {"init_scale_factor", 0.1}})},
  };
  return rows;
}

void apply_preset(TrainOptions& options, const std::string& name) {
  apply_named(options, presets(), "preset", name);
}

}  // namespace tessera
