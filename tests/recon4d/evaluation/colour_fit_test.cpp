// The colour fit and the scores of timesteps, from images with known answers, and in a report.
#include "recon4d/evaluation/pixel_sums.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "recon4d/evaluation/dynamic_regions.h"
#include "recon4d/evaluation/evaluate.h"
#include "recon4d/evaluation/metrics.h"
#include "tests/recon4d/model/small_models.h"

namespace tessera::testing {
namespace {

constexpr int kWidth = 16, kHeight = 12, kTimesteps = 4;

/// Two standing test cameras. The truth is what is drawn, each 8-bit value made another by
/// change(camera, timestep, index, value).
struct Rig {
  Scene scene;
  GaussianModel model = random_model(40, 40);

  template <class Change>
  explicit Rig(Change&& change) {
    const Scene noise = noise_scene(kWidth, kHeight);
    for (int camera = 0; camera < 2; ++camera)
      for (int t = 0; t < kTimesteps; ++t) {
        Frame frame = noise.frames[size_t(camera)];
        frame.name = frame.camera_name + "/" + std::to_string(t);
        frame.time = double(t) / (kTimesteps - 1);
        frame.frame_number = frame.timestep = t;
        frame.split = Split::kTest;
        const RenderedImage image = render_one(model, {frame.camera, frame.time});
        frame.image = quantise(image.planar(), kWidth, kHeight);
        for (size_t i = 0; i < frame.image.data.size(); ++i)
          frame.image.data[i] = uint8_t(change(camera, t, i, int(frame.image.data[i])));
        scene.frames.push_back(frame);
      }
  }

  EvaluationReport evaluated() const {
    const auto backend = make_cpu_backend();
    EvaluateOptions options;
    options.structure = StructureDetail::kSsim;
    return evaluate(*backend, model, scene, Split::kTest, options);
  }
};

constexpr double kGain[2][3] = {{0.5, 0.7, 0.6}, {0.8, 0.55, 0.75}};
constexpr double kOffset[2][3] = {{40, 10, 20}, {5, 50, 30}};  // 8-bit units

int tinted(int camera, int, size_t i, int value) {
  return int(std::floor(kGain[camera][i % 3] * value + kOffset[camera][i % 3] + 0.5));
}

TEST(ColourFit, FindsTheLineExactly) {
  PixelSums sums;
  for (int64_t x : {10, 60, 200}) {
    ++sums.pixels;
    for (size_t c = 0; c < 3; ++c) {
      const int64_t y = (int64_t(c) - 1) * x + 51;  // a gain below 0 and of 0, too
      ChannelSums& s = sums.channels[c];
      s = {s.x + x, s.y + y, s.xx + x * x, s.xy + x * y, s.yy + y * y};
    }
  }
  const ColourFit fit = fit_colour(sums);
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(fit.gain[c], double(c) - 1, 1e-12);
    EXPECT_NEAR(fit.offset[c], 0.2, 1e-12);
  }
  EXPECT_LT(fit.mean_squared_error(sums), 1e-12);
}

// The gain is not determined there. Bug put back: no least variance, so that it is NaN; seen to
// fail.
TEST(ColourFit, OfOneValueIsAnOffsetAlone) {
  PixelSums sums;
  sums.pixels = 7;
  for (ChannelSums& s : sums.channels)
    s = {7 * 103, 7 * 52, 7 * 103 * 103, 7 * 103 * 52, 7 * 52 * 52};
  const ColourFit fit = fit_colour(sums);
  EXPECT_EQ(fit.gain[0], 1);
  EXPECT_NEAR(fit.offset[0], -0.2, 1e-12);
  EXPECT_LT(fit.mean_squared_error(sums), 1e-12);
}

// Bugs put back, each seen to fail: one fit for all cameras; the fit without the offset.
TEST(ColourFit, OfEachCameraIsFoundAndItsScoreIsHigh) {
  const Rig rig(tinted);
  const EvaluationReport report = rig.evaluated();
  EXPECT_LT(report.all.psnr.value(), 25);
  EXPECT_GT(report.all.psnr_fit.value(), 55) << "rounding alone";
  ASSERT_EQ(report.colour_fit.size(), 2u);
  for (int camera = 0; camera < 2; ++camera)
    for (size_t c = 0; c < 3; ++c) {
      const ColourFit& fit = report.colour_fit[size_t(camera)].fit;
      EXPECT_NEAR(fit.gain[c], kGain[camera][c], 0.01) << camera << " " << c;
      EXPECT_NEAR(fit.offset[c], kOffset[camera][c] / 255, 0.005) << camera << " " << c;
    }
  const nlohmann::json object = to_json(report, rig.model);
  EXPECT_EQ(object["psnr_fit"], report.all.psnr_fit.value());
  EXPECT_EQ(object["colour_fit"]["cam01"]["gain"][2], report.colour_fit[1].fit.gain[2]);
  EXPECT_EQ(object["colour_fit"]["cam00"]["offset"].size(), 3u);
  EXPECT_EQ(object["per_view"][3]["psnr_fit"], report.views[3].psnr_fit.value());
  EXPECT_TRUE(object["definitions"].contains("psnr_fit"));
}

/// The noise of a few pixels at each timestep makes them move; most stand still.
int flashing(int camera, int t, size_t i, int value) {
  const int tint = tinted(camera, t, i, value);
  return (i / 3) % 5 == size_t(t) ? (tint + 90) % 256 : tint;
}

// Bug put back: a fit over the moving pixels for their score; seen to fail.
TEST(ColourFit, MovingAndStaticPixelsAddUpToAll) {
  const Rig rig(flashing);
  const EvaluationReport report = rig.evaluated();
  const DynamicRegions regions(rig.scene, DynamicRegions::Of::kAllFrames,
                               rig.scene.split_indices(Split::kTest));
  const auto squared_error = [](double psnr) { return std::pow(10.0, -psnr / 10); };
  for (size_t i = 0; i < report.views.size(); ++i) {
    const std::vector<uint8_t> moves = regions.mask_of(rig.scene.frames[i]);
    const double all = double(moves.size());
    const double share = double(std::count(moves.begin(), moves.end(), uint8_t{255})) / all;
    ASSERT_GT(share, 0);
    ASSERT_LT(share, 1);
    const ViewScore& view = report.views[i];
    EXPECT_NEAR(squared_error(view.psnr_fit.value()),
                share * squared_error(view.psnr_fit_dynamic.value()) +
                    (1 - share) * squared_error(view.psnr_fit_static.value()),
                1e-12);
    EXPECT_NEAR(squared_error(view.psnr),
                share * squared_error(view.psnr_dynamic.value()) +
                    (1 - share) * squared_error(view.psnr_static.value()),
                1e-12);
  }
  EXPECT_GE(report.all.psnr_fit_static.value(), report.all.psnr_fit_dynamic.value());
}

// Bug put back: the mask not asked; seen to fail.
TEST(ColourFit, LeavesOutMaskedPixels) {
  Rig rig([](int camera, int t, size_t i, int value) {
    return i < 3 * kWidth ? 255 - value : tinted(camera, t, i, value);
  });
  EXPECT_LT(rig.evaluated().all.psnr_fit.value(), 40);
  for (Frame& frame : rig.scene.frames) {
    Image8 mask{kWidth, kHeight, 1, std::vector<uint8_t>(size_t(kWidth) * kHeight, 255)};
    std::fill_n(mask.data.begin(), kWidth, uint8_t{0});
    frame.mask = std::move(mask);
  }
  const EvaluationReport report = rig.evaluated();
  EXPECT_GT(report.all.psnr_fit.value(), 55);
  EXPECT_NEAR(report.colour_fit[0].fit.gain[1], kGain[0][1], 0.01);
}

// Bug put back: the highest PSNR; seen to fail.
TEST(TimestepScores, PoolCamerasAndFindTheWorst) {
  const Rig rig([](int camera, int t, size_t, int value) {
    return t == 2 && camera == 1 ? 255 - value : value;
  });
  const EvaluationReport report = rig.evaluated();
  ASSERT_EQ(report.timesteps.size(), size_t(kTimesteps));
  EXPECT_EQ(report.timesteps[1].psnr, 100);
  EXPECT_EQ(report.timesteps[2].views, 2);
  const double half = report.views[size_t(kTimesteps) + 2].mse / 2;  // the other camera has none
  EXPECT_NEAR(report.timesteps[2].psnr, psnr_of_mse(half), 1e-12);
  const nlohmann::json object = to_json(report, rig.model);
  EXPECT_EQ(object["worst_timestep"]["frame_number"], 2);
  EXPECT_EQ(object["worst_timestep"], object["timesteps"][2]);
  EXPECT_NEAR(double(object["worst_timestep"]["time"]), 2.0 / 3, 1e-12);
  EXPECT_LT(double(object["worst_timestep"]["psnr_dynamic"]), 20);
  EXPECT_FALSE(worst_timestep({}).has_value());
}

}  // namespace
}  // namespace tessera::testing
