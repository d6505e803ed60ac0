// A training of the program that selects its model by validation frames: the exported model, the
// messages, the splits that are not read, and the resume after a stop. Source: failure modes D4,
// D5, D7, E5.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "ingest/files/png.h"
#include "tests/support/random.h"
#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class CliValidation : public ::testing::Test {
 protected:
  CliValidation() { work.film_object("six", 6, 32); }
  /// Steps so large that the score soon falls; two frames of six are validation frames.
  json train(const std::string& run, const std::vector<std::string>& more = {}) const {
    // clang-format off
    std::vector<std::string> arguments{
        "train", work.at("six"), "-o", work.at(run), "--preset", "fast", "--iterations", "60",
        "--schedule-iterations", "60", "--init-points", "300", "--batch", "2",
        "--densify-until", "0", "--reorder-interval", "0",
        "--validation-share", "0.34", "--validate-interval", "3", "--checkpoint-every", "4",
        "--lr-scale", "0.3", "--lr-mean", "0.05", "--lr-mean-final", "0.05", "--lr-sh", "0.3", "--deterministic", "true"};
    // clang-format on
    arguments.insert(arguments.end(), more.begin(), more.end());
    return work.run_json(arguments);
  }
  /// The one best_*.ply of a run.
  std::string best_of(const std::string& run) const {
    std::string best;
    for (const auto& entry : fs::directory_iterator(work / run))
      if (entry.path().filename().string().starts_with("best_")) {
        EXPECT_EQ(best, "") << "older ones are removed";
        best = run + "/" + entry.path().filename().string();
      }
    return best;
  }
  CliWorkspace work;
};

// D5, D6, D7. Bugs put back, each seen to fail: the last model shipped; the last model scored; best
// models of earlier steps left behind; the size of a checkpoint given as the model's; evaluation on
// the clock of training.
TEST_F(CliValidation, ShipsTheBestModelAndReportsItsStep) {
  const json trained = train("run", {"--stop-patience", "4"});
  const json& checks = trained["validation"];
  EXPECT_EQ(checks["frames"], 2);
  EXPECT_EQ(checks["stopped"], true);
  EXPECT_EQ(trained["finished"], true);
  EXPECT_LT(trained["iterations"], 60);
  EXPECT_EQ(checks["stop_iteration"], trained["iterations"]);
  EXPECT_LT(checks["best_iteration"], trained["iterations"]);
  EXPECT_LE(checks["best_seconds"], trained["seconds"]);
  EXPECT_GT(checks["best_psnr"], checks["last_psnr"]);
  EXPECT_EQ(best_of("run"), "run/best_" + std::string(checks["best_iteration"] < 10 ? "0" : "") +
                                "0000" + checks["best_iteration"].dump() + ".ply");

  const json scores = work.run_json({"evaluate", work.at("run")});
  const json last = work.run_json({"evaluate", work.at("run/checkpoint.ckpt")});
  EXPECT_EQ(scores["psnr"], trained["scores"]["psnr"]) << "as in memory, so after a reload";
  EXPECT_EQ(scores["splits"]["val"]["ssim"], trained["scores"]["splits"]["val"]["ssim"]);
  EXPECT_NE(scores["psnr"], last["psnr"]) << "the checkpoint resumes from the last step";
  EXPECT_TRUE(last["bytes"].is_null()) << "it has the optimizer in it";
  EXPECT_EQ(trained["bytes"], fs::file_size(work / "run/model.ply"));
  EXPECT_EQ(scores["bytes"], trained["bytes"]);
  EXPECT_EQ(scores["num_gaussians"], trained["num_gaussians"]);

  const json& wall = trained["wall_seconds"];
  for (const char* part : {"load", "device", "init", "steps", "decisions", "evaluate", "save"})
    EXPECT_GT(wall[part], 0) << part;
  EXPECT_EQ(wall.size(), 10u);
  // the clock of training runs in its steps and decisions alone
  EXPECT_GE(double(wall["steps"]) + double(wall["unseen"]) + double(wall["decisions"]),
            0.99 * double(trained["seconds"]));
}

// D4. Bug put back: the test split checked in place of the validation frames; seen to fail.
TEST_F(CliValidation, NeverReadsHeldOutImages) {
  const json first = train("first", {"--stop-patience", "4"});
  Random random(5);
  for (const char* split : {"test", "val"})
    for (const auto& entry : fs::directory_iterator(work / "six" / split)) {
      Image8 noise = read_png(entry.path());
      for (uint8_t& value : noise.data) value = uint8_t(random.below(256));
      write_png(entry.path(), noise);
    }
  const json second = train("second", {"--stop-patience", "4"});
  EXPECT_NE(first["scores"]["psnr"], second["scores"]["psnr"]) << "the images are others";
  EXPECT_EQ(first["iterations"], second["iterations"]);
  EXPECT_EQ(first["validation"]["best_iteration"], second["validation"]["best_iteration"]);
  EXPECT_EQ(work.read("first/model.ply"), work.read("second/model.ply"));
}

// E5. Bugs put back, each seen to fail: the best model not brought back; the record not saved; a
// best model that is missing not detected.
TEST_F(CliValidation, TwoHalvesAreTheWhole) {
  const json whole = train("whole");
  const int64_t best = whole["validation"]["best_iteration"];
  EXPECT_LT(best, 50);
  train("halves", {"--stop-after", std::to_string(best + 1)});
  const json resumed =
      work.run_json({"train", work.at("six"), "-o", work.at("halves"), "--resume"});
  for (const char* key : {"checks", "best_iteration", "best_psnr", "without_gain"})
    EXPECT_EQ(resumed["validation"][key], whole["validation"][key]) << key;
  EXPECT_EQ(work.read("halves/model.ply"), work.read("whole/model.ply"));
  // an ended run is not trained on
  train("ended", {"--stop-patience", "4"});
  const std::string model = work.read("ended/model.ply");
  const json again = work.run_json({"train", work.at("six"), "-o", work.at("ended"), "--resume"});
  EXPECT_EQ(again["validation"]["stopped"], true);
  EXPECT_EQ(work.read("ended/model.ply"), model);
  fs::remove(work / best_of("ended"));
  work.expect_refused({"train", work.at("six"), "-o", work.at("ended"), "--resume"},
                      {"best_", "best model so far", "--overwrite"}, 65);
}

// A run that was killed between its best model and the checkpoint that names it leaves a file that
// a device would not make again to the bit. Bug put back: a file of that name is kept; seen to
// fail.
TEST_F(CliValidation, ABestModelOfAKilledRunIsNotTakenForThisOnes) {
  const json whole = train("whole");
  const int64_t best = whole["validation"]["best_iteration"];
  const std::string name = fs::path(best_of("whole")).filename().string();
  train("killed", {"--stop-after", std::to_string(best - 1)});
  work.write("killed/" + name, "of another run");
  work.run_json({"train", work.at("six"), "-o", work.at("killed"), "--resume"});
  EXPECT_EQ(work.read("killed/" + name), work.read("whole/" + name));
}

TEST_F(CliValidation, OneFrameCannotBeShared) {
  work.edit_json("six/transforms_train.json",
                 [](json& file) { file["frames"] = json::array({file["frames"][0]}); });
  work.expect_refused(
      {"train", work.at("six"), "-o", work.at("run"), "--static", "--validation-share", "0.5"},
      {"six", "1 training frame", "--validation-share 0"});
}

}  // namespace
}  // namespace tessera::testing
