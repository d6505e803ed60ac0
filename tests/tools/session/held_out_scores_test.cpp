// The scores of an evaluation in words.
#include "tools/session/held_out_scores.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using nlohmann::json;

json group(int views, double psnr) {
  return {{"views", views}, {"psnr", psnr}};
}

/// Of two test views, one of a novel view at a known timestep; something moves in them.
json moving_scores() {
  json test = group(2, 27.585);
  test.update({{"ssim", 0.90612},
               {"ssim_zero", 0.9},
               {"ssim_inside", 0.91},
               {"ms_ssim", nullptr},
               {"dssim", 0.05},
               {"lpips", nullptr},
               {"psnr_dynamic", 21.49},
               {"psnr_static", 30.05},
               {"psnr_fit", 28.125},
               {"psnr_fit_dynamic", 21.9},
               {"psnr_fit_static", 31.25},
               {"timesteps", {1, 2}},
               {"worst_timestep", {{"frame_number", 17}, {"psnr", 26.5}}},
               {"objects",
                {{{"name", "thrown ball"},
                  {"psnr", 19.25},
                  {"worst", {{"frame_number", 12}, {"psnr", 15.5}}}}}},
               {"novel_view", group(1, 26)},
               {"novel_time", group(0, 0)},
               {"novel_view_and_time", group(0, 0)},
               {"withheld", group(0, 0)},
               {"flicker", {{"change_error", 3.23}, {"still_deviation", 0.55}}},
               {"per_view", {1, 2}}});
  return {{"splits", {{"test", test}}}};
}

TEST(HeldOutScores, AreDescribedInTheWordsOfTheField) {
  EXPECT_EQ(scores_text(moving_scores()),
            "test views (2): PSNR 27.59 dB, SSIM 0.9061\n"
            "  sharp where it stands still, soft where it moves\n"
            "  novel views at known timesteps (1): PSNR 26.00 dB\n"
            "  moving pixels 21.5 dB, static pixels 30.1 dB\n"
            "  temporal error 3.23/255, flicker of static pixels 0.55/255\n"
            "  PSNR 28.12 dB after the best gain and offset of each camera, moving pixels 21.9 dB, "
            "static pixels 31.2 dB\n"
            "  lowest timestep: frame 17, PSNR 26.50 dB\n"
            "  thrown ball: PSNR 19.25 dB, lowest at frame 12, 15.50 dB");
  EXPECT_EQ(scores_text(json::object()), "");
}

TEST(HeldOutScores, AllDetailsOnRequest) {
  const std::string text = scores_text(moving_scores(), ScoreDetail::kAll);
  for (const char* part :
       {"SSIM 0.9061 with reflect padding, 0.9000 with zero padding, 0.9100 without padding",
        "MS-SSIM n/a, D-SSIM 0.0500, LPIPS n/a"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
  json scores = moving_scores();
  scores["splits"]["test"]["lpips"] = 0.125;
  EXPECT_NE(scores_text(scores).find("LPIPS 0.1250"), std::string::npos);
}

TEST(HeldOutScores, AVerdictOfAllWhereNothingDiffers) {
  const auto verdict = [](double still, double moving, const char* split) {
    json scores = moving_scores();
    scores["splits"]["test"].update({{"psnr_static", still}, {"psnr_dynamic", moving}});
    return scores_text({{"splits", {{split, scores["splits"]["test"]}}}});
  };
  EXPECT_NE(verdict(26, 29.9, "test").find("\n  good\n"), std::string::npos);
  EXPECT_NE(verdict(36, 12, "val").find("recognisable at best where it moves"), std::string::npos);
  EXPECT_EQ(verdict(26, 29.9, "train").find("good"), std::string::npos) << "no new views";
}

TEST(HeldOutScores, NumbersAreRoundedAndAbsentOnesNamed) {
  EXPECT_EQ(number_text(27.586, 2), "27.59");
  EXPECT_EQ(number_text(7, 1), "7.0");
  EXPECT_EQ(number_text(nullptr, 2), "n/a");
  EXPECT_EQ(views_text("val"), "validation views");
  EXPECT_EQ(views_text("train"), "training views");
}

}  // namespace
}  // namespace tessera
