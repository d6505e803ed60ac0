// The values of presets for several cameras that film at the same time, one camera and one
// timestep.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/clocks/timesteps.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options_json.h"

namespace tessera::testing {
namespace {

/// `counts`: training frames of each camera.
Scene rig_scene(const std::vector<int>& counts) {
  Scene scene;
  for (size_t c = 0; c < counts.size(); ++c)
    for (int i = 0; i < counts[c]; ++i) {
      Frame frame;
      frame.camera_name = "cam" + std::to_string(c);
      frame.name = frame.camera_name + "/" + std::to_string(i);
      frame.time = counts[c] > 1 ? double(i) / (counts[c] - 1) : 0;
      frame.camera.width = 8;
      frame.camera.height = 6;
      frame.camera.translation = {double(c), 0, 0};
      scene.frames.push_back(frame);
    }
  number_timesteps(scene);
  return scene;
}

// Bugs put back: cameras counted that have a single frame; a monocular capture taken for a rig;
// each seen to fail.
TEST(SceneFacts, OfRigsAndOthers) {
  const SceneFacts rig = facts_of(rig_scene({10, 10, 9, 10}));
  EXPECT_TRUE(rig.rig());
  EXPECT_EQ(rig.cameras, 4);
  EXPECT_EQ(rig.timesteps, 10);
  EXPECT_NEAR(rig.extent, 1.1 * 1.5, 1e-12);
  EXPECT_FALSE(facts_of(rig_scene({50})).rig()) << "one camera that moves";
  EXPECT_FALSE(facts_of(rig_scene({10, 10})).rig());
  EXPECT_FALSE(facts_of(rig_scene({10, 1, 1, 1})).rig()) << "one camera with photos beside it";
  EXPECT_FALSE(facts_of(rig_scene({2, 2, 2})).rig());
  Scene still = rig_scene({10, 10, 10});
  still.is_static = true;
  EXPECT_FALSE(facts_of(still).rig());
}

// Bug put back: test views counted; seen to fail.
TEST(SceneFacts, OfOneViewATimestep) {
  EXPECT_TRUE(facts_of(rig_scene({50})).single_view);
  EXPECT_FALSE(facts_of(rig_scene({1})).single_view) << "one timestep";
  EXPECT_FALSE(facts_of(rig_scene({10, 10})).single_view);
  Scene turns = rig_scene({10, 10});
  for (size_t i = 0; i < turns.frames.size(); ++i) turns.frames[i].time = double(i) / 19;
  number_timesteps(turns);
  EXPECT_TRUE(facts_of(turns).single_view) << "cameras that take turns";
  Scene tested = rig_scene({10, 10});
  for (size_t i = 10; i < 20; ++i) tested.frames[i].split = Split::kTest;
  EXPECT_TRUE(facts_of(tested).single_view);
  for (size_t i = 10; i < 20; ++i) tested.frames[i].time += 0.01;
  number_timesteps(tested);
  EXPECT_TRUE(facts_of(tested).single_view) << "tested between its timesteps";
}

// Bugs put back: shares that rise above one; few views left alone; test views counted; protocols of
// papers changed; each seen to fail.
TEST(StillPresets, FitToTheViews) {
  const auto of_views = [](const char* preset, int64_t views) {
    TrainOptions options;
    apply_preset(options, preset, {.still = true, .views = views});
    return options;
  };
  for (const char* preset : {"fast", "balanced", "best"}) {
    const TrainOptions many = of_views(preset, 90), few = of_views(preset, 9);
    EXPECT_EQ(to_json(many), to_json(of_views(preset, 1000))) << preset;
    EXPECT_EQ(to_json(many), to_json(of_views(preset, 0))) << preset << ", number not known";
    EXPECT_EQ(few.iterations, std::min<int64_t>(many.iterations, 2700)) << preset;
    EXPECT_NEAR(few.gaussians_per_pixel, 0.1 * many.gaussians_per_pixel, 1e-12) << preset;
    EXPECT_NEAR(few.lr_sh_rest, 0.1 * many.lr_sh_rest, 1e-12) << preset;
    EXPECT_NEAR(few.opacity_weight, 10 * many.opacity_weight, 1e-12) << preset;
    EXPECT_NEAR(few.scale_weight, 10 * many.scale_weight, 1e-12) << preset;
    EXPECT_EQ(few.peak_gaussians, many.peak_gaussians) << preset;
    EXPECT_NO_THROW(validate(of_views(preset, 1))) << preset;
  }
  for (const char* preset : {"3dgs", "mcmc", "faster-gs"})
    EXPECT_EQ(to_json(of_views(preset, 9)), to_json(of_views(preset, 90))) << preset;
  Scene still = rig_scene({3, 1, 1, 2});
  still.frames[3].split = Split::kTest;
  EXPECT_EQ(facts_of(still).views, 3) << "of four cameras, of which one is tested";
}

// Bugs put back: a limit by the pixels alone; weights that rise with the cameras; those of one
// camera that moves changed; all steps with few cameras; a share above one with many; each seen to
// fail.
TEST(RigPresets, FitToTheCameras) {
  const auto of_cameras = [](const char* preset, int64_t cameras, int64_t timesteps) {
    TrainOptions options;
    apply_preset(options, preset,
                 {.camera_pixels = cameras * 76800,
                  .views = cameras,
                  .cameras = cameras,
                  .timesteps = timesteps});
    return options;
  };
  for (const char* preset : {"balanced", "best"}) {
    EXPECT_EQ(of_cameras(preset, 3, 24).peak_gaussians, 3 * 76800 / 16) << preset;
    EXPECT_EQ(of_cameras(preset, 4, 24).peak_gaussians, 4 * 76800 / 16) << preset;
    EXPECT_EQ(of_cameras(preset, 8, 24).peak_gaussians, 8 * 76800 / 8) << preset;
    EXPECT_EQ(of_cameras(preset, 64, 24).peak_gaussians, 400000) << preset;
    for (const int64_t cameras : {4, 8, 27}) {
      const TrainOptions options = of_cameras(preset, cameras, 24);
      EXPECT_NEAR(options.opacity_weight, 0.1 / double(cameras), 1e-12) << preset;
      EXPECT_EQ(options.scale_weight, options.opacity_weight) << preset;
      EXPECT_LE(options.iterations, 1000 * cameras) << preset;
      EXPECT_NEAR(options.lr_sh_rest, double(cameras) / 30 * 1.25e-4, 1e-12) << preset;
    }
    EXPECT_EQ(to_json(of_cameras(preset, 30, 24))["lr_sh_rest"],
              to_json(of_cameras(preset, 64, 24))["lr_sh_rest"])
        << preset;
    EXPECT_NEAR(of_cameras(preset, 8, 24).static_threshold, std::sqrt(1e6 / 76800), 1e-9) << preset;
    TrainOptions plain;
    apply_preset(plain, preset);
    EXPECT_EQ(of_cameras(preset, 27, 24).iterations, plain.iterations) << preset;
    EXPECT_EQ(plain.static_threshold, 1) << preset << ", one camera";
    EXPECT_EQ(of_cameras(preset, 1, 100).opacity_weight, plain.opacity_weight) << preset;
  }
  for (const char* preset : {"fast", "faster-gs", "yang4d"})
    EXPECT_EQ(of_cameras(preset, 4, 24).opacity_weight, of_cameras(preset, 27, 24).opacity_weight)
        << preset;
}

// Each does more than the one before. Bug put back: the initial opacity of MCMC densification in
// `best`; seen to fail.
TEST(StillPresets, AreInOrder) {
  TrainOptions before;
  before.iterations = before.peak_gaussians = 0;
  for (const char* preset : {"fast", "balanced", "best"}) {
    TrainOptions options;
    apply_preset(options, preset, {.still = true, .views = 200});
    EXPECT_EQ(options.densification, Densification::kBudget) << preset;
    EXPECT_EQ(options.init_opacity, 0.1) << preset << " takes nothing from MCMC densification";
    EXPECT_GT(options.iterations, before.iterations) << preset;
    EXPECT_GT(options.peak_gaussians, before.peak_gaussians) << preset;
    before = options;
  }
}

// Bug put back: options of nodes before those of the preset; seen to fail.
TEST(SingleViewPresets, TryNodesAndHaveOptionsForThem) {
  for (const Preset& preset : presets()) {
    TrainOptions options, with_nodes;
    apply_preset(options, preset.name, {.single_view = true});
    apply_preset(with_nodes, preset.name, {.single_view = true, .nodes = true});
    const bool tries = preset.name == "balanced" || preset.name == "best";
    EXPECT_EQ(options.motion == Motion::kAuto, tries) << preset.name;
    EXPECT_EQ(options.min_blending_weight, 0) << preset.name;
    EXPECT_EQ(with_nodes.min_blending_weight > 0, tries) << preset.name;
    EXPECT_EQ(with_nodes.densification == Densification::kMcmc, preset.name == "mcmc")
        << preset.name;
    TrainOptions rig;
    apply_preset(rig, preset.name, {.cameras = 8, .timesteps = 31, .extent = 2});
    EXPECT_NE(rig.motion, Motion::kAuto) << preset.name;
  }
}

// Bugs put back, each seen to fail: the steps of `best` for a few frames; weights of photos.
TEST(SingleViewPresets, FitToTheFramesThatNodesCarry) {
  const auto of_images = [](const char* preset, int64_t images) {
    TrainOptions options;
    apply_preset(options, preset, {.images = images, .single_view = true, .nodes = true});
    return options;
  };
  EXPECT_EQ(of_images("best", 150).iterations, 30000);
  EXPECT_EQ(of_images("best", 50).iterations, 15000);
  for (const char* preset : {"balanced", "best"}) {
    const TrainOptions many = of_images(preset, 150), few = of_images(preset, 45);
    EXPECT_NEAR(few.lr_sh_rest, 0.5 * many.lr_sh_rest, 1e-12) << preset;
    EXPECT_EQ(few.opacity_weight, many.opacity_weight) << preset;
    EXPECT_EQ(few.gaussians_per_pixel, many.gaussians_per_pixel) << preset;
  }
}

/// The options of a preset for a rig of that many frames.
TrainOptions on_rig(const char* preset, int64_t frames, double extent = 2) {
  TrainOptions options;
  apply_preset(options, preset, {.cameras = 8, .timesteps = frames, .extent = extent});
  return options;
}

// Bug put back: extents left in clip lengths; seen to fail.
TEST(RigPresets, ExtentsAndRatesFollowTheFrameRate) {
  for (const char* preset : {"fast", "balanced", "best"}) {
    const TrainOptions shorter = on_rig(preset, 31), longer = on_rig(preset, 301);
    EXPECT_NEAR(shorter.init_time_scale, 10 * longer.init_time_scale, 1e-12) << preset;
    EXPECT_NEAR(shorter.lr_mean_time, 10 * longer.lr_mean_time, 1e-12) << preset;
    EXPECT_LT(shorter.init_time_scale, 10.0 / 30) << preset << ": a few frames";
    EXPECT_NEAR(on_rig(preset, 31, 4).lr_mean_time, shorter.lr_mean_time / 2, 1e-12)
        << preset << ": the rate is per scene extent";
    EXPECT_EQ(shorter.exposure, ExposureGains::kAuto) << preset;
    EXPECT_EQ(shorter.near_plane, 0) << preset << ": from the cloud";
    EXPECT_GT(shorter.moving_weight, 0) << preset;
  }
}

// Bug put back: space cleared with eight; seen to fail.
TEST(RigPresets, StepsAreByCamerasAndFewOfThemClearTheSpaceBeforeThem) {
  const auto options_of = [](const char* preset, int64_t cameras) {
    TrainOptions options;
    apply_preset(options, preset, {.cameras = cameras, .timesteps = 31, .extent = 2});
    return options;
  };
  for (const char* preset : {"balanced", "best"}) {
    EXPECT_EQ(options_of(preset, 3).iterations, 3000) << preset;
    EXPECT_EQ(options_of(preset, 6).iterations, 6000) << preset;
    EXPECT_EQ(options_of(preset, 4).clear_distance, -1) << preset << ": from the cloud";
    EXPECT_EQ(options_of(preset, 7).clear_distance, -1) << preset;
    EXPECT_EQ(options_of(preset, 8).clear_distance, 0) << preset;
  }
  EXPECT_EQ(options_of("balanced", 8).iterations, 7000);
  EXPECT_EQ(options_of("best", 8).iterations, 8000);
  EXPECT_EQ(options_of("fast", 4).iterations, 2000);
}

// Images may be shown larger than those of the training (research/growth.md). Bugs put back: no
// filter with `fast`, none of photos; what is missed spawned of photos and of one camera; each seen
// to fail.
TEST(RigPresets, AllFilterAndWhatIsUnseenOrMissedIsARigsAffair) {
  for (const char* preset : {"fast", "balanced", "best"}) {
    TrainOptions other[3];
    apply_preset(other[0], preset);
    apply_preset(other[1], preset, {.still = true});
    apply_preset(other[2], preset, {.single_view = true});
    for (const TrainOptions& options : other) {
      EXPECT_TRUE(options.filter_2d) << preset;
      EXPECT_EQ(options.min_blending_weight, 0) << preset;
      EXPECT_FALSE(options.spawn_missed) << preset;
    }
    const TrainOptions rig = on_rig(preset, 31);
    EXPECT_TRUE(rig.filter_2d) << preset;
    const bool decides = rig.decide_motion;
    EXPECT_EQ(rig.min_blending_weight > 0, decides) << preset;
    EXPECT_EQ(rig.spawn_missed, decides) << preset;
  }
}

// Bugs put back: `adc` with `fast`; MCMC densification in `best` of one camera; each seen to fail.
TEST(SingleViewPresets, GrowByTheBudgetWhereThatGains) {
  for (const char* preset : {"fast", "balanced", "best"}) {
    TrainOptions options;
    apply_preset(options, preset, {.single_view = true});
    const bool balanced = preset == std::string("balanced");
    EXPECT_EQ(options.densification, balanced ? Densification::kAdc : Densification::kBudget)
        << preset;
  }
}

TEST(RigPresets, OtherScenesAndProtocolsAreUnchanged) {
  for (const char* preset : {"faster-gs", "yang4d", "3dgs", "mcmc"}) {
    TrainOptions plain;
    apply_preset(plain, preset);
    EXPECT_EQ(to_json(on_rig(preset, 31)), to_json(plain)) << preset;
  }
  TrainOptions plain;
  apply_preset(plain, "balanced");
  EXPECT_EQ(plain.exposure, ExposureGains::kNone);
  EXPECT_EQ(plain.init_time_scale, TrainOptions().init_time_scale);
  EXPECT_EQ(plain.near_plane, TrainOptions().near_plane);
  EXPECT_EQ(plain.moving_weight, 0);
}

}  // namespace
}  // namespace tessera::testing
