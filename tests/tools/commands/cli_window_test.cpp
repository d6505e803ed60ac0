// `tessera train --window`: one part of a moving scene as a training of its own, and what scores
// it.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

/// A room at 24 timesteps; what is held out is of the first one.
class CliWindow : public ::testing::Test {
 protected:
  CliWindow() {
    EXPECT_EQ(work.run({"synth", "room", "-o", work.at("room"), "--layout", "dnerf", "--frames",
                        "24", "--held-out-frames", "1", "--width", "48", "--height", "36",
                        "--supersampling", "1", "--points", "200"})
                  .exit_code,
              0);
    work.edit_json("room/transforms_train.json", [](json& file) {
      for (size_t i = 0; i < 24; ++i) file["frames"][i]["time"] = double(i) / 23;
    });
    for (const char* held_out : {"room/transforms_val.json", "room/transforms_test.json"})
      work.edit_json(held_out, [](json& file) { file["frames"][0]["time"] = 0; });
  }
  std::vector<std::string> arguments(const std::string& run,
                                     const std::vector<std::string>& more) const {
    std::vector<std::string> words = work.train_arguments(run, more);
    words[1] = work.at("room");
    return words;
  }
  const CliWorkspace work;
};

// Bug put back: the whole scene is trained; seen to fail. Finds also: evaluate scores the timesteps
// beyond the core, or the whole scene; the times of the model are those of the clip.
TEST_F(CliWindow, TrainsAndScoresAPartOfTheClip) {
  const json trained = work.run_json(arguments("run", {"--window", "1/3"}));
  EXPECT_TRUE(trained["finished"]);
  const json config = json::parse(work.read("run/config.json"));
  EXPECT_EQ(config["window"], "1/3");
  const json whole = work.run_json({"info", work.at("room")});
  const json info = work.run_json({"info", work.at("run/model.ply")});
  const double share = 15.0 / 23;  // timesteps 0 to 7 and eight more, of 24
  EXPECT_NEAR(double(info["time_axis"]["duration"]), share * double(whole["time_axis"]["duration"]),
              1e-6);
  const json scores = work.run_json({"evaluate", work.at("run"), "--split", "train"});
  std::set<double> times;
  for (const json& view : scores["per_view"]) times.insert(double(view["time"]));
  EXPECT_EQ(times.size(), 8u) << "timesteps of the core";
  EXPECT_NEAR(*times.rbegin(), 7.0 / 15, 1e-6) << "on the time of the model";
}

// Bug put back: another window may be resumed; seen to fail. Finds also: a resumed training is of
// the whole scene.
TEST_F(CliWindow, IsPartOfTheRequest) {
  const auto ends = [&](const std::vector<std::string>& more) {
    return work.run(arguments("run", more)).exit_code;
  };
  EXPECT_EQ(ends({"--window", "1/3", "--stop-after", "2"}), 0);
  work.expect_refused(
      {"train", work.at("room"), "-o", work.at("run"), "--resume", "--window", "2/3"},
      {"--window 2/3", "begun with window 1/3"});
  EXPECT_EQ(
      work.run({"train", work.at("room"), "-o", work.at("run"), "--resume", "--backend", "cpu"})
          .exit_code,
      0);
  EXPECT_EQ(json::parse(work.read("run/config.json"))["window"], "1/3");
  EXPECT_EQ(ends({"--window", "1/3"}), 0);
  work.expect_refused(arguments("run", {"--window", "3/3"}), {"finished run", "window 1/3 → 3/3"});
  work.expect_refused(arguments("run", {}), {"window 1/3 → the whole clip"});
  work.expect_refused(arguments("new", {"--window", "4/3"}), {"--window 4/3", "1/12"});
  work.expect_refused(arguments("new", {"--window", "1/13"}), {"window 1/13", "24 timesteps"});
}

}  // namespace
}  // namespace tessera::testing
