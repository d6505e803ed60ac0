// Invalid input to the whole program gives exit code 2 and one line with the remedy.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;
const char* const kTrainJson = "capture/transforms_train.json";
const char* const kPicture = "capture/train/r_000.png";

/// Trains on the capture after something was done to it.
void expect_capture_refused(const CliWorkspace& work, const std::vector<std::string>& parts) {
  work.expect_refused(work.train_arguments("run"), parts);
  EXPECT_FALSE(std::filesystem::exists(work / "run/model.ply"));
}

// Seen to fail with read_transforms not asking whether the folder is there.
TEST(CliBadInput, MissingFolder) {
  const CliWorkspace work;
  work.expect_refused({"train", work.at("nowhere"), "-o", work.at("run")},
                      {"nowhere", "no such folder", "check the path"});
  if (TESSERA_HAS_INGEST)
    work.expect_refused({"ingest", work.at("nowhere"), "-o", work.at("scene")},
                        {"nowhere", "no such folder"});
  work.expect_refused({"evaluate", work.at("nowhere")}, {"nowhere", "expected a run folder"});
  work.expect_refused({"info", work.at("nowhere")}, {"nowhere", "no such file or folder"});
}

// Seen to fail with read_file not looking for the list.
TEST(CliBadInput, JsonWithoutFrames) {
  const CliWorkspace work;
  work.edit_json(kTrainJson, [](json& file) { file.erase("frames"); });
  expect_capture_refused(work, {"transforms_train.json", "no list 'frames'"});
  work.write(kTrainJson, "{\"frames\": [");
  expect_capture_refused(work, {"transforms_train.json", "not valid JSON"});
}

// Seen to fail with find_image returning a path that does not exist.
TEST(CliBadInput, ListedFrameIsAbsent) {
  const CliWorkspace work;
  std::filesystem::remove(work / kPicture);
  expect_capture_refused(work, {"transforms_train.json, frame 0", "no such image", "r_000"});
}

// Seen to fail with read_png going on after libpng's error.
TEST(CliBadInput, TruncatedImage) {
  const CliWorkspace work;
  const std::string bytes = work.read(kPicture);
  work.write(kPicture, bytes.substr(0, bytes.size() / 2));
  expect_capture_refused(work, {"r_000.png", "truncated"});
  work.write(kPicture, "this is not an image");
  expect_capture_refused(work, {"r_000.png", "is not a PNG"});
}

// Seen to fail with the PNG header's size ignored.
TEST(CliBadInput, ZeroSizeImage) {
  const CliWorkspace work;
  std::string bytes = work.read(kPicture);
  bytes.replace(16, 4, std::string(4, '\0'));  // IHDR: width
  work.write(kPicture, bytes);
  expect_capture_refused(work, {"r_000.png", "size 0x32"});
}

// Seen to fail with pose_rows taking whatever the matrix holds.
TEST(CliBadInput, PoseWithNan) {
  const CliWorkspace work;
  std::string text = work.read(kTrainJson);
  const size_t row = text.find('[', text.find("transform_matrix")) + 1;
  const size_t number = text.find_first_of("-0123456789", row);
  text.replace(number, text.find_first_of(",\n]", number) - number, "NaN");
  work.write(kTrainJson, text);
  expect_capture_refused(work, {"transforms_train.json, frame 0", "transform_matrix", "NaN"});
}

// Seen to fail with check_rotation returning at once.
TEST(CliBadInput, SingularPose) {
  const CliWorkspace work;
  work.edit_json(kTrainJson, [](json& file) {
    json& matrix = file["frames"][1]["transform_matrix"];
    for (json& row : matrix) row[0] = 0;
  });
  expect_capture_refused(work, {"transforms_train.json, frame 1"});
}

// Seen to fail with normalise_times taking equal times as one timestep.
TEST(CliBadInput, TimesAllEqual) {
  const CliWorkspace work;
  for (const char* split : {"train", "val", "test"})
    work.edit_json(std::string("capture/transforms_") + split + ".json", [](json& file) {
      for (json& frame : file["frames"]) frame["time"] = 0.25;
    });
  expect_capture_refused(work, {"transforms_train.json", "times", "--static"});
  EXPECT_EQ(work.train("run", {"--static", "--iterations", "2"}).exit_code, 0);
}

// Seen to fail with read_splats passing over missing columns.
TEST(CliBadInput, WrongPly) {
  const CliWorkspace work;
  const std::string cloud = work.at("capture/ground_truth/points.ply");
  work.expect_refused({"evaluate", cloud, "--scene", work.at("capture")},
                      {"points.ply", "f_dc_0", "expected a Gaussian splat .ply"});
  work.write("broken.ply", "ply\nformat ascii 1.0\nelement vertex many\nend_header\n");
  work.expect_refused({"export", work.at("broken.ply"), "-o", work.at("out")}, {"broken.ply"});
}

// Seen to fail with model_kind taking every file for a .ply.
TEST(CliBadInput, NotAModel) {
  const CliWorkspace work;
  const std::string image = work.at(kPicture);
  work.expect_refused({"evaluate", image, "--scene", work.at("capture")},
                      {"r_000.png", "not a model", "expected a run folder"});
  work.expect_refused({"render", work.at("capture"), "--cameras", work.at("capture"), "-o", "x"},
                      {"is a scene, no model"});
  work.expect_refused({"info", image}, {"r_000.png", "unrecognised file type"});
}

// Finds: what is missing in the folder, in place of what the folder is.
TEST(CliBadInput, AFolderOfAnotherKindIsNamed) {
  const CliWorkspace work;
  const std::string scene = work.at("capture"), run = work.at("run");
  ASSERT_EQ(work.train("run", {"--iterations", "2"}).exit_code, 0);
  for (const char* command : {"run", "ingest", "train"})
    work.expect_refused({command, run, "-o", work.at("out")},
                        {"run: is what a training made", "tessera view " + run, scene});
  work.expect_refused({"doctor", run}, {"is what a training made, no capture or scene"});
  work.expect_refused({"view", scene}, {"is a scene, no model; train one: tessera train " + scene});
  work.write("dance/a.txt", "");
  work.expect_refused({"view", work.at("dance")},
                      {"holds no model", "tessera run " + work.at("dance") + " -o OUT"});
  work.write("done/stages.json", R"({"asked": {}})");
  work.expect_refused({"run", scene, "-o", work.at("done/other")},
                      {"done/other: lies in " + work.at("done") + ", the output of another run"});
}

// Seen to fail with size and checksum of a checkpoint not compared.
// Bugs put back, each seen to fail: an option that takes the capture behind it for a second value;
// a config.json of others taken for that of a training, and the stages.json of others above OUT.
TEST(CliBadInput, ForeignFilesAndTheOrderOfWordsAreNoFault) {
  TESSERA_SKIP_WITHOUT_INGEST();
  const CliWorkspace work;
  work.write("capture/config.json", R"({"scene": 3})");
  work.write("above/stages.json", "{}");
  const ChildResult made = work.run(
      {"ingest", "--cloud", "none", "--sync", "none", work.at("capture"), "-o", work.at("scene")});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  const ChildResult run = work.run({"run", "--preset", "fast", "--iterations", "2", "--cloud",
                                    "none", work.at("capture"), "-o", work.at("above/out")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST(CliBadInput, TruncatedCheckpoint) {
  const CliWorkspace work;
  ASSERT_EQ(work.train("run").exit_code, 0);
  const std::string whole = work.read("run/checkpoint.ckpt");
  for (const size_t kept : {whole.size() - 1, whole.size() / 2, size_t(30), size_t(9)}) {
    work.write("run/checkpoint.ckpt", whole.substr(0, kept));
    work.expect_refused({"info", work.at("run/checkpoint.ckpt")},
                        {"checkpoint.ckpt", "checkpoint"});
  }
  std::string damaged = whole;
  damaged[damaged.size() - 100] ^= 1;
  work.write("run/checkpoint.ckpt", damaged);
  const ChildResult resumed =
      work.run({"train", work.at("capture"), "-o", work.at("run"), "--resume"});
  EXPECT_EQ(resumed.exit_code, 65) << resumed.err;
  for (const char* part : {"checkpoint.ckpt", "checksum"})
    EXPECT_NE(resumed.err.find(part), std::string::npos) << resumed.err;
}

// Seen to fail with the errors of making folders ignored.
TEST(CliBadInput, PathBelowAFileCannotBeWritten) {
  const CliWorkspace work;
  work.write("file", "");
  const std::string below = work.at("file/out");
  const std::vector<std::string> parts{below + ":", "cannot be created", "Not a directory"};
  work.expect_refused({"synth", "object", "-o", below, "--layout", "dnerf"}, parts);
  if (TESSERA_HAS_INGEST) work.expect_refused({"ingest", work.at("capture"), "-o", below}, parts);
  work.expect_refused({"train", work.at("capture"), "-o", below}, parts);
}

// Bug put back: what std::filesystem throws is taken for a failure of the program; seen to fail.
TEST(CliBadInput, PathThatTheSystemRefuses) {
  const CliWorkspace work;
  const std::string path = work.at(std::string(300, 'a'));
  for (const char* command : {"info", "train"}) {
    std::vector<std::string> arguments{command, path};
    if (arguments[0] == "train") arguments.insert(arguments.end(), {"-o", work.at("run")});
    work.expect_refused(arguments, {path + ": cannot be reached (File name too long)"});
  }
}

// Seen to fail with nearest_name returning the last name.
TEST(CliBadInput, UnknownNamesSuggestTheNearest) {
  const CliWorkspace work;
  work.expect_refused(work.train_arguments("run", {"--itrations", "3"}),
                      {"unknown option '--itrations'", "did you mean '--iterations'?"});
  work.expect_refused(work.train_arguments("run", {"--preset", "fats"}),
                      {"unknown preset 'fats'", "did you mean 'fast'?"});
  work.expect_refused({"trian", "x"}, {"unknown command 'trian'", "did you mean 'train'?"});
  work.expect_refused({"synth", "romo", "-o", work.at("x")}, {"'romo'", "did you mean 'room'?"});
  work.expect_refused(work.train_arguments("run", {"--backend", "vulkan"}),
                      {"unknown backend 'vulkan'", "cpu or cuda"});
  work.expect_refused({"export", work.at("x"), "-o", work.at("y"), "--format", "fbx"},
                      {"unknown format 'fbx'", "there are tessera, page, html, model, ftgs"});
  if (TESSERA_HAS_INGEST)
    work.expect_refused({"ingest", work.at("capture"), "-o", work.at("x"), "--poses", "magic"},
                        {"--poses 'magic'", "n3dv"});
}

// Seen to fail with OutputFolder taking any folder.
TEST(CliBadInput, ForeignFoldersAreNotWrittenInto) {
  const CliWorkspace work;
  ASSERT_EQ(work.train("run").exit_code, 0);
  std::filesystem::create_directory(work / "foreign");
  work.write("foreign/letter", "");
  work.expect_refused({"export", work.at("run"), "-o", work.at("foreign")},
                      {"foreign", "--overwrite"});
  work.expect_refused(
      {"render", work.at("run"), "--cameras", work.at("capture"), "-o", work.at("foreign")},
      {"foreign", "--overwrite"});
  work.expect_refused({"synth", "object", "-o", work.at("run"), "--layout", "dnerf"}, {"run"});
  work.expect_refused(work.train_arguments("run", {"--seed", "5"}), {"run", "--overwrite"});
}

}  // namespace
}  // namespace tessera::testing
