// The contribution of each Gaussian to the training images over all cameras and timesteps: its
// blending weight, the squared error that its removal or simplification adds, and the part of the
// residual over it that changes with time. A pass draws sweep after sweep until the decisions by
// one half of the frames cost little by the other half. Source: docs/explanation/size.md.
#pragma once
#include <array>
#include <functional>
#include <limits>
#include <vector>

#include "recon4d/evaluation/frame_sample.h"
#include "recon4d/evaluation/scoring_pass.h"

namespace tessera {

/// Squared error is summed over pixels and RGB, range [0, 1], without the image's gain. Sums are
/// scaled from the frames drawn to all training frames.
struct SetContributions {
  std::vector<float> weight;    // [N] Σ w, w = T·α: blending weight, pixels
  std::vector<float> moving;    // [N] that of pixels that may move; 0: not known
  std::vector<float> removal1;  // [N] first- and
  std::vector<float> removal2;  // [N] second-order change of the squared error without it alone
  /// [N][d] squared error added by the bands above degree d
  std::vector<std::array<float, 3>> truncation_error;
  std::vector<float> mean_time, opacity;  // [N] mean timestep and mean effective opacity, by w
  /// [N] what is left over it, as it changes with time; of the static set. Not scaled to all
  /// frames: what chance gives does not scale.
  struct Change {
    float gain = 0;  // squared error that a colour of its own at every timestep would take away
    float timesteps = 0;   // at which it was seen
    float freedom = 0;     // of these beyond the first of each series
    float light = 0;       // squared error that its removal would add, timestep by timestep
    float peak_time = 0;   // where most of the gain is
    float peak_gain = 0;   // there
    float lasting = 0;     // timesteps whose gain is at least half of that
    Vec3<float> colour{};  // to be added there
  };
  std::vector<Change> change;

  void resize(int64_t count);
  /// What its removal costs: the second order of the squared error, of which that in pixels that
  /// may move counts twice, as far as it is known what moves. What moves is a small part of all
  /// pixels of a clip, and the first that is seen.
  double removal_cost(size_t n) const { return double(removal2[n]) * motion_factor(n); }
  /// 1 + the share of its blending weight that is in pixels that may move.
  double motion_factor(size_t n) const {
    return weight[n] > 0 ? 1 + double(moving[n]) / double(weight[n]) : 1;
  }
};

struct Contributions {
  SetContributions sets[2];               // static, dynamic
  double squared_error = 0;               // over all training images
  double samples = 0;                     // 3 · pixels that count in them
  double share = 1;                       // of the training frames, that were drawn
  double gain_variance = 0;               // of the images' gains around their camera's mean
  bool motion_known = false;              // whether masks told SetContributions::moving
  double psnr_after(double added) const;  // dB, of the mean squared error with so much more
};

/// Frames that a decision draws: a sample, as more of them decide alike.
inline constexpr int64_t kSampledFrames = 256;

/// Draws as many sweeps of `sample` as have `frames`, or all. `draw`: frames [begin, end) of
/// `sample`, at most FrameSample::at_once. Returns the share of the frames that were drawn.
double draw_sample(const FrameSample& sample, int64_t frames,
                   const std::function<void(int64_t begin, int64_t end)>& draw);

/// By the sweeps of `sample` that have `frames`, scaled to all. What these do not draw is unknown.
Contributions measure_contributions(Backend& backend, const GaussianModel& model,
                                    const FrameSample& sample,
                                    int64_t frames = std::numeric_limits<int64_t>::max());

}  // namespace tessera
