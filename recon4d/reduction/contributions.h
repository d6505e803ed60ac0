// What: what each Gaussian does for the training images, over all of their cameras and timesteps:
//       its light, the squared error that removing or simplifying it adds, and the error over it
//       that changes with time.
// Not: decisions (pruning.h, static_demotion.h, dynamic_promotion.h).
// Source: docs/explanation/size.md.
#pragma once
#include <array>
#include <functional>
#include <vector>

#include "recon4d/evaluation/scoring_pass.h"

namespace tessera {

/// Squared error is summed over pixels and RGB, range [0, 1], without the image's gain. Sums are
/// scaled from the frames drawn to all training frames.
struct SetContributions {
  std::vector<float> weight;    // [N] Σ w, w = T·α: pixels of light
  std::vector<float> removal1;  // [N] first- and
  std::vector<float> removal2;  // [N] second-order change of the squared error without it alone
  /// [N][d] squared error added by the bands above degree d
  std::vector<std::array<float, 3>> truncation_error;
  std::vector<float> mean_time, opacity;  // [N] mean timestep and mean effective opacity, by w
  /// [N] what is left over it, as it changes with time; of the static set. Not scaled to all
  /// frames: what chance gives does not scale.
  struct Change {
    float gain = 0;  // squared error that a colour of its own at every timestep would take away
    float timesteps = 0;  // at which it was seen
    float freedom = 0;    // of these beyond the first of each series
    float light = 0;  // squared error that leaving its light out would add, timestep by timestep
    float peak_time = 0;   // where most of the gain is
    float peak_gain = 0;   // there
    float lasting = 0;     // timesteps whose gain is at least half of that
    Vec3<float> colour{};  // to be added there
  };
  std::vector<Change> change;

  void resize(int64_t count);
};

struct Contributions {
  SetContributions sets[2];               // static, dynamic
  double squared_error = 0;               // over all training images
  double samples = 0;                     // 3 · pixels that count in them
  double share = 1;                       // of the training frames, that were drawn
  double gain_variance = 0;               // of the images' gains around their camera's mean
  double psnr_after(double added) const;  // dB, of the mean squared error with so much more
};

/// The price of each element, [N] static set first: the squared error over all training frames up
/// to which it is given up, by what is known of them.
using ElementPrices = std::function<std::vector<double>(const Contributions&)>;

/// Draws frames until removals at these prices are decided precisely (precision.h); without
/// `prices` all.
Contributions measure_contributions(Backend& backend, const GaussianModel& model,
                                    const FrameSample& sample, const ElementPrices& prices = {});

}  // namespace tessera
