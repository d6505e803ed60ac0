// The contribution of each Gaussian over all views and timesteps: sums of blending weights, removal
// and SH cuts against models without it, the change of the remaining model in closed form, and the
// frames that are used. Sums over the pixels of a splat are tested in
// tests/kernels/backend/backend_sensitivity_test.cpp. Source: failure modes, "Modelling no more
// than a scene needs".
#include "recon4d/reduction/contributions.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "recon4d/model/element_edits.h"
#include "recon4d/reduction/pruning.h"
#include "tests/recon4d/model/plain_gaussians.h"
#include "tests/recon4d/model/small_models.h"

namespace tessera::testing {
namespace {

/// Frames of noise for a model to be held against.
Scene noisy_ring(int cameras, int timesteps, int size = 20) {
  Scene scene =
      tiny_capture({.cameras = cameras, .timesteps = timesteps, .size = size}, empty_model());
  Random random(3);
  for (Frame& frame : scene.frames)
    for (uint8_t& byte : frame.image.data) byte = uint8_t(random.below(256));
  return scene;
}

double light_of(const SetContributions& set) {
  double sum = 0;
  for (const float w : set.weight) sum += double(w);
  return sum;
}

// Bug put back: elements of the dynamic set read from the static one's; seen to fail.
TEST(Contributions, WeightsAreTheLightOfTheImages) {
  for (const SetForm form : {SetForm::kPair, SetForm::kVelocity}) {
    const GaussianModel model = random_model(30, 20, 7, 4, form);
    const Scene scene = noisy_ring(5, 3);
    const Contributions contributions = contributions_of(model, scene);
    double light[2] = {0, 0};
    const FrameSample sample = sample_training_frames(scene);
    GaussianModel still = model.clone_values();
    still.dynamic_set = model.dynamic_set.like();
    still.dynamic_set.resize(0);
    for (const RenderedImage& image : images_of(model, sample))
      for (const float a : image.alpha) light[0] += double(a);
    EXPECT_NEAR(light_of(contributions.sets[0]) + light_of(contributions.sets[1]), light[0],
                1e-5 * light[0]);
    EXPECT_GT(light_of(contributions.sets[1]), 0.1 * light[0]);
    for (const RenderedImage& image : images_of(still, sample))
      for (const float a : image.alpha) light[1] += double(a);
    EXPECT_NEAR(light_of(contributions_of(still, scene).sets[0]), light[1], 1e-5 * light[1]);
    EXPECT_EQ(contributions.samples, 5 * 3 * 3 * 20 * 20);
  }
}

// ΔC of a Gaussian alone is α (b − c), b: the background. Bug put back: the last view in place of
// the sum; seen to fail.
TEST(Contributions, RemovalOfOneAloneInClosedForm) {
  GaussianModel model = empty_model();
  model.static_set = plain_set(model.static_set, {{{0.1, 0, 0}, {0.9, 0.4, 0.2}, 0.4, 0.7}});
  model.background = {51, 102, 0};
  const Scene scene = noisy_ring(4, 2);
  const Contributions contributions = contributions_of(model, scene);
  const FrameSample sample = sample_training_frames(scene);
  const std::vector<RenderedImage> images = images_of(model, sample);
  const double less[3] = {0.2 - 0.9, 0.4 - 0.4, 0.0 - 0.2};
  double first = 0, second = 0, error = 0, weight = 0, size = 0;
  for (size_t i = 0; i < images.size(); ++i) {
    const RenderedImage& image = images[i];
    const std::vector<uint8_t>& truth = scene.frames[size_t(sample.frames[i])].image.data;
    const size_t pixels = image.alpha.size();
    for (size_t p = 0; p < pixels; ++p) {
      const double a = double(image.alpha[p]);
      weight += a;
      for (size_t c = 0; c < 3; ++c) {
        const double r = double(image.rgb[c * pixels + p]) - truth[3 * p + c] / 255.0;
        error += r * r;
        first += 2 * r * a * less[c];
        second += a * less[c] * a * less[c];
        size += std::abs(2 * r * a * less[c]);
      }
    }
  }
  EXPECT_NEAR(double(contributions.sets[0].weight[0]), weight, 1e-5 * weight);
  EXPECT_NEAR(double(contributions.sets[0].removal2[0]), second, 1e-4 * second);
  EXPECT_NEAR(double(contributions.sets[0].removal1[0]), first, 1e-5 * size);
  EXPECT_NEAR(contributions.squared_error, error, 1e-6 * error);
  EXPECT_NEAR(contributions.psnr_after(0), -10 * std::log10(error / double(contributions.samples)),
              1e-4);
  EXPECT_NEAR(contributions.psnr_after(second),
              -10 * std::log10((error + second) / double(contributions.samples)), 1e-4);
}

void add_masks_and_gains(Scene& scene, FrameSample& sample) {
  Random random(4);
  for (Frame& frame : scene.frames) {
    Image8 mask{frame.image.width, frame.image.height, 1, {}};
    for (size_t p = 0; p < frame.image.data.size() / 3; ++p)
      mask.data.push_back(random.uniform(0, 1) < 0.6 ? 255 : 0);
    frame.mask = std::move(mask);
  }
  for (size_t i = 0; i < sample.frames.size(); ++i)
    sample.maps.push_back(
        colour_gain<double>({random.uniform(0.7, 1.3), random.uniform(0.7, 1.3), 1}));
}

// Bug put back: the mean over all cameras in place of the camera's; seen to fail.
TEST(Contributions, GainsVaryOverTimeNotBetweenCameras) {
  const GaussianModel model = random_model(3, 0, 7);
  const Scene scene = noisy_ring(4, 3, 8);
  FrameSample sample = sample_training_frames(scene);
  const auto variance = [&](double wobble) {
    sample.maps.clear();
    for (int64_t i = 0; i < sample.count(); ++i) {
      const Frame& frame = sample.frame(i);
      const double gain = frame.camera_name == scene.frames[0].camera_name ? 0.8 : 1.1;
      const double off = double(frame.frame_number - 1) * wobble;  // −1, 0, 1 timestep
      sample.maps.push_back(colour_gain<double>({gain + off, gain, gain}));
    }
    return measure_contributions(*make_cpu_backend(), model, sample).gain_variance;
  };
  EXPECT_NEAR(variance(0), 0, 1e-12);
  EXPECT_NEAR(variance(0.1), 0.01 * (2.0 / 3) / 3, 1e-12) << "of one channel of three";
  sample.maps.clear();
  EXPECT_EQ(measure_contributions(*make_cpu_backend(), model, sample).gain_variance, 0);
}

// Bug put back: the mask of the first frame of a batch for all; seen to fail.
TEST(Contributions, RemovalIsTheRealChangeWithMasksAndGains) {
  const GaussianModel model = random_model(12, 8, 7, 4);
  Scene scene = noisy_ring(5, 2);
  FrameSample sample = sample_training_frames(scene);
  add_masks_and_gains(scene, sample);
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  const Contributions contributions = measure_contributions(*backend, model, sample);
  int64_t counted = 0, moved = 0;
  for (const Frame& frame : scene.frames)
    counted += 3 * (int64_t(frame.mask.data().size()) -
                    std::count(frame.mask.data().begin(), frame.mask.data().end(), 0));
  EXPECT_EQ(contributions.samples, counted);
  const std::vector<RenderedImage> images = images_of(model, sample);
  double error = 0;
  for (size_t i = 0; i < images.size(); ++i) {
    const Frame& frame = scene.frames[size_t(sample.frames[i])];
    const size_t pixels = frame.mask.data().size();
    for (size_t j = 0; j < 3 * pixels; ++j) {
      const size_t p = j % pixels, c = j / pixels;
      if (frame.mask.data()[p] == 0) continue;
      const double r = channel_response(sample.maps[i])[int(c)] * double(images[i].rgb[j]) -
                       frame.image.data[3 * p + c] / 255.0;
      error += r * r;
    }
  }
  EXPECT_NEAR(contributions.squared_error, error, 1e-5 * error);
  const std::vector<Removal> order = removal_order(model, contributions);
  for (const Removal& removal : order) {
    KeptElements elements = kept_elements(model, order, model.count());
    std::erase(elements.set_elements[removal.set], removal.element);
    const double change =
        measure_contributions(*backend, with_elements(model, elements), sample).squared_error -
        contributions.squared_error;
    const SetContributions& set = contributions.sets[removal.set];
    const double first = double(set.removal1[size_t(removal.element)]);
    const double second = double(set.removal2[size_t(removal.element)]);
    EXPECT_NEAR(first + second, change, 1e-4 * (std::abs(first) + second) + 1e-4)
        << removal.element;
    moved += std::abs(change) > 0.1;
  }
  EXPECT_GT(moved, 10);
}

/// Zeroes the bands of element n above degree d, in all levels of time.
void zero_above(GaussianSet& set, int64_t n, int d) {
  const GaussianSpans<float> v = set.values();
  const int width = 3 * set.coefficients();
  for (int i = 3 * sh_coefficients(d); i < width; ++i) {
    v.at(kSh, n)[i] = 0;
    for (int level = 0; level < set.time_levels(); ++level) v.at(kShTime, n)[level * width + i] = 0;
  }
}

/// Colours so near grey that no channel is clamped.
void soften(GaussianModel& model) {
  for (GaussianSet* set : {&model.static_set, &model.dynamic_set})
    for (int g : {int(kSh), int(kShTime)})
      if (g < set->groups())
        for (float& x : set->group(Group(g)).value) x *= 0.4f;
}

// Bug put back: bands counted from one too far; seen to fail.
TEST(Contributions, CutsAreTheRealChangeWhereBandsAreZeroed) {
  for (const bool in_time : {false, true}) {
    GaussianModel model = in_time ? random_model_in_time(8, 8, 2) : random_model(8, 8);
    soften(model);
    const Scene scene = noisy_ring(4, 2);
    const Contributions contributions = contributions_of(model, scene);
    double largest = 0;
    for (int k = 0; k < 2; ++k)
      for (int64_t n = 0; n < 8; n += 2)
        for (int d = 0; d < 3; ++d) {
          GaussianModel cut = model.clone_values();
          zero_above(k == 0 ? cut.static_set : cut.dynamic_set, n, d);
          const double change =
              contributions_of(cut, scene).squared_error - contributions.squared_error;
          const double promised =
              double(contributions.sets[k].truncation_error[size_t(n)][size_t(d)]);
          EXPECT_NEAR(promised, change, 1e-4 * std::max(1.0, std::abs(change)))
              << "set " << k << " element " << n << " degree " << d;
          largest = std::max(largest, std::abs(change));
        }
    EXPECT_GT(largest, 0.3) << "there is something to be seen";
  }
}

/// One static Gaussian before frames of one grey each, by timestep.
struct Ramp {
  GaussianModel model = empty_model();
  Scene scene = noisy_ring(6, 5);  // more than a batch at a timestep

  explicit Ramp(const std::vector<int>& grey) {
    model.static_set = plain_set(model.static_set, {{{0, 0.1, 0}, {0.6, 0.5, 0.3}, 0.3, 0.9}});
    for (Frame& frame : scene.frames)
      std::fill(frame.image.data.begin(), frame.image.data.end(),
                uint8_t(grey[size_t(frame.frame_number)]));
  }
};

// Σ_t |s_t|²/W_t − |Σ s|²/Σ W, s and W by the light of the one that there is. Bugs put back, each
// seen to fail: a timestep closed after every batch; the mean over timesteps not taken off.
TEST(Contributions, ChangeOfARampInClosedForm) {
  const Ramp ramp({20, 60, 100, 160, 250});
  const FrameSample sample = sample_training_frames(ramp.scene);
  const std::vector<RenderedImage> images = images_of(ramp.model, sample);
  std::map<double, std::array<double, 4>> sums;  // s by channel, W
  for (size_t i = 0; i < images.size(); ++i) {
    const Frame& frame = ramp.scene.frames[size_t(sample.frames[i])];
    std::array<double, 4>& sum = sums[frame.time];
    const size_t pixels = images[i].alpha.size();
    for (size_t p = 0; p < pixels; ++p) {
      const double w = double(images[i].alpha[p]);
      for (size_t c = 0; c < 3; ++c)
        sum[c] += w * (double(images[i].rgb[c * pixels + p]) - frame.image.data[3 * p + c] / 255.0);
      sum[3] += w * w;
    }
  }
  double gain = 0, peak = 0, peak_time = -1;
  std::array<double, 4> all{}, best{};
  for (const auto& [time, s] : sums) {
    const double here = (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]) / s[3];
    gain += here;
    if (here > peak) {
      peak = here;
      peak_time = time;
      best = s;
    }
    for (size_t c = 0; c < 4; ++c) all[c] += s[c];
  }
  const double lasting = gain / peak;
  gain -= (all[0] * all[0] + all[1] * all[1] + all[2] * all[2]) / all[3];
  const SetContributions::Change change =
      contributions_of(ramp.model, ramp.scene).sets[0].change[0];
  EXPECT_NEAR(double(change.gain), gain, 1e-4 * gain);
  EXPECT_GT(gain, 10);
  EXPECT_EQ(change.timesteps, 5);
  EXPECT_EQ(change.peak_time, float(peak_time));
  EXPECT_NEAR(double(change.peak_gain), peak, 1e-4 * peak);
  EXPECT_NEAR(double(change.lasting), lasting, 1e-4);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(double(change.colour[c]), -best[size_t(c)] / best[3], 1e-4);
}

// Bug put back: the mean over timesteps not taken off; seen to fail.
TEST(Contributions, NothingChangesWhereTheResidualIsTheSame) {
  const Ramp still({90, 90, 90, 90, 90});
  const SetContributions::Change change =
      contributions_of(still.model, still.scene).sets[0].change[0];
  EXPECT_GT(change.peak_gain, 0.1f) << "something is left over";
  EXPECT_LT(change.gain, 1e-5f * change.peak_gain);
  EXPECT_EQ(change.timesteps, 5);
}

// Bug put back: timesteps not counted; seen to fail.
TEST(Contributions, CountsTheTimestepsAtWhichItIsSeen) {
  Ramp ramp({90, 90, 200, 90, 90});
  for (Frame& frame : ramp.scene.frames)
    if (frame.frame_number == 2 || frame.frame_number == 4)
      frame.camera = look_at({9, 0, 0}, {99, 0, 0}, 20, 20, 28);  // away
  const SetContributions::Change change =
      contributions_of(ramp.model, ramp.scene).sets[0].change[0];
  EXPECT_EQ(change.timesteps, 3);
  EXPECT_LT(change.gain, 1e-5f * change.peak_gain) << "what no view shows does not change";
}

// Bug put back: sums divided by a constant; seen to fail.
TEST(Contributions, TimestepAndOpacityAreMeansByLight) {
  GaussianModel model = empty_model();
  model.dynamic_set = plain_set(model.dynamic_set,
                                {{{0, 0, 0}, {0.9, 0.2, 0.1}, 0.3, 0.6, 0.2, 0.3}, {{0, 99, 0}}});
  const Scene scene = noisy_ring(3, 5);
  const FrameSample sample = sample_training_frames(scene);
  const std::vector<RenderedImage> images = images_of(model, sample);
  double light = 0, timestep = 0, opacity = 0;
  for (size_t i = 0; i < images.size(); ++i) {
    const double t = scene.frames[size_t(sample.frames[i])].time, d = (t - 0.2) / 0.3;
    double here = 0;
    for (const float a : images[i].alpha) here += double(a);
    light += here;
    timestep += here * t;
    opacity += here * 0.6 * std::exp(-0.5 * d * d);
  }
  const SetContributions set = std::move(contributions_of(model, scene).sets[1]);
  EXPECT_NEAR(double(set.mean_time[0]), timestep / light, 1e-5);
  EXPECT_NEAR(double(set.opacity[0]), opacity / light, 1e-5);
  EXPECT_EQ(set.weight[1], 0.0f);
  EXPECT_EQ(set.opacity[1], 0.0f) << "without light it is nothing, and no division by it";
}

// Whole sweeps, batch by batch, until there are enough frames.
TEST(Contributions, ASampleIsWholeSweeps) {
  Scene scene;
  scene.frames.resize(1);
  scene.frames[0].camera.width = scene.frames[0].camera.height = 1024;
  FrameSample sample;
  sample.scene = &scene;
  for (int k = 0; k < 8; ++k) sample.sweeps.push_back({10 * k, 10 * k + 10});
  sample.frames.resize(80);
  for (const auto& [frames, drawn] : {std::pair{0, 10}, {10, 10}, {11, 20}, {80, 80}, {999, 80}}) {
    int64_t next = 0;
    const double share = draw_sample(sample, frames, [&](int64_t begin, int64_t end) {
      EXPECT_EQ(begin, next);
      EXPECT_LE(end - begin, 4);
      EXPECT_EQ(begin / 10, (end - 1) / 10) << "of one sweep";
      next = end;
    });
    EXPECT_EQ(next, drawn);
    EXPECT_DOUBLE_EQ(share, drawn / 80.0);
  }
}

/// Two passes over 8 cameras × 64 timesteps: all frames, and two sweeps of 32.
struct ShortAndWhole {
  Contributions few, all;
};
ShortAndWhole short_and_whole(const GaussianModel& model, const Scene& scene) {
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  const FrameSample sample = sample_training_frames(scene);
  return {measure_contributions(*backend, model, sample, 64),
          measure_contributions(*backend, model, sample)};
}

// Bug put back: sums of the frames drawn; seen to fail.
TEST(Contributions, AreScaledToAllFrames) {
  const GaussianModel model = random_model(12, 0, 7, 4);
  Scene scene = noisy_ring(8, 64, 12);
  for (Frame& frame : scene.frames)  // every camera the same at all timesteps
    for (const Frame& other : scene.frames)
      if (other.frame_number == 0 && other.camera_name == frame.camera_name)
        frame.image = other.image;
  const auto [few, all] = short_and_whole(model, scene);
  EXPECT_EQ(few.share, 2.0 / 16);
  EXPECT_EQ(all.share, 1);
  EXPECT_EQ(few.samples, all.samples);
  EXPECT_NEAR(few.squared_error, all.squared_error, 1e-6 * all.squared_error);
  for (size_t n = 0; n < 12; ++n) {
    const double weight = double(all.sets[0].weight[n]), removal = double(all.sets[0].removal2[n]);
    EXPECT_NEAR(double(few.sets[0].weight[n]), weight, 1e-4 * weight) << n;
    EXPECT_NEAR(double(few.sets[0].removal2[n]), removal, 1e-4 * removal) << n;
    EXPECT_EQ(few.sets[0].mean_time[n] > 0, all.sets[0].mean_time[n] > 0) << n;
    EXPECT_NEAR(few.sets[0].change[n].gain, 0, 1e-3 * (1 + double(few.sets[0].change[n].light)));
    EXPECT_LE(few.sets[0].change[n].freedom, 64) << n;
  }
}

// What is there for one timestep of the clip alone, as a thrown ball is at one place, is seen by a
// pass of an eighth of the frames, whichever timestep it is (failure mode F1). Bug put back: whole
// timesteps, all cameras of each; seen to fail.
TEST(Contributions, AnyTimestepIsSeenByAShortPass) {
  GaussianModel model = empty_model();
  std::vector<Plain> plain;
  for (int t = 0; t < 64; ++t)
    plain.push_back({{0, 0, 0}, {0.9, 0.2, 0.1}, 0.3, 0.6, t / 63.0, 0.002});
  model.dynamic_set = plain_set(model.dynamic_set, plain);
  const auto [few, all] = short_and_whole(model, noisy_ring(8, 64, 12));
  for (size_t n = 0; n < plain.size(); ++n) EXPECT_GT(few.sets[1].weight[n], 0) << n;
}

}  // namespace
}  // namespace tessera::testing
