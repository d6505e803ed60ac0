// The summary text of a run, also in builds that contain the player page.
#include "tools/run/run_summary.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using nlohmann::json;

json result_of_run() {
  return {{"training",
           {{"num_gaussians", 12}, {"num_static", 9}, {"num_dynamic", 3}, {"bytes", 4'810'000}}},
          {"export", {{"folder", "a b/frames"}, {"frames", 24}, {"bytes", 206'000'000}}},
          {"player", {{"folder", "a b/player"}, {"format", "html"}, {"bytes", 950'000}}},
          {"model", "a b/run/model.ply"},
          {"metrics", "a b/run/metrics.json"},
          {"scene", "a b/scene"},
          {"out", "a b"},
          {"camera_path", "orbit"},
          {"stage_seconds", {{"train", 241.2}, {"evaluate", 3.04}, {"page", 1.0}}},
          {"total_seconds", 245.6}};
}

TEST(RunSummary, HasQualityPlacesAndWhatToTypeNext) {
  EXPECT_EQ(run_summary(result_of_run(), ScoreDetail::kUsual),
            R"(Quality    no test views
Gaussians  12 (9 static + 3 dynamic)
Time       4:06 (train 4:01, evaluate 3.0 s, page 1.0 s; the other stages were done before)
Sizes      model 4.8 MB, player page 950.0 kB

Results
  player page     a b/player/index.html
  model           a b/run/model.ply
  scores          a b/run/metrics.json
  prepared scene  a b/scene
  PLY frames      a b/frames (24 files, 206.0 MB)

Next
  Open a b/player/index.html in a web browser; from another machine, by a server:
    tessera view 'a b'
  Render a video along a camera path (orbit or spiral):
    tessera render 'a b' --path orbit --mp4 -o 'a b/orbit.mp4'
  Export the model for another program (formats: tessera export --help):
    tessera export 'a b' --format ply -o 'a b/ply')");
}

TEST(RunSummary, AFolderThatIsTooLargeForOnePageIsServed) {
  json result = result_of_run();
  result["player"]["format"] = "page";
  const std::string text = run_summary(result, ScoreDetail::kUsual);
  EXPECT_NE(text.find("Show the player in a web browser:\n    tessera view 'a b'\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("Open a b"), std::string::npos) << text;
}

TEST(RunSummary, OfAStageThatRanInThisCallAndOfNone) {
  json result = result_of_run();
  result["stage_seconds"] = json::object();
  EXPECT_NE(run_summary(result, ScoreDetail::kUsual).find("Time       all stages were done before"),
            std::string::npos);
  result["stage_seconds"] = {{"ingest", 1.0}, {"train", 2.0}, {"evaluate", 3.0}};
  EXPECT_NE(run_summary(result, ScoreDetail::kUsual)
                .find("4:06 (ingest 1.0 s, train 2.0 s, evaluate 3.0 s)\n"),
            std::string::npos);
}

}  // namespace
}  // namespace tessera
