// Invalid command lines (unknown names, values that cannot be read, a file in place of a folder),
// help and version.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/tools/commands/cli_workspace.h"
#include "tools/web/web_page.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Refused without a suggestion.
void expect_no_suggestion(const CliWorkspace& work, const std::vector<std::string>& arguments,
                          const std::string& part) {
  work.expect_refused(arguments, {part});
  const std::string message = work.run(arguments).err;
  EXPECT_EQ(message.find("did you mean"), std::string::npos) << message;
}

/// The program as `run` left it: OUT with a model of two steps in OUT/run.
void run_once(const CliWorkspace& work, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{
      "run", work.at("capture"), "-o",  work.at("out"), "--iterations", "2", "--batch",
      "1",   "--init-points",    "100", "--backend",    "cpu"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ChildResult result = work.run(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.err;
}

// Bug put back: the name of the program left out of a command's usage; seen to fail.
TEST(CliUsage, HelpAndVersionAreCommandsToo) {
  const CliWorkspace work;
  const auto output = [&](const std::vector<std::string>& arguments) {
    const ChildResult result = work.run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    return result.out;
  };
  EXPECT_EQ(output({"help"}), output({"--help"}));
  EXPECT_NE(output({"help"}).find("doctor"), std::string::npos);
  EXPECT_EQ(output({"help", "train"}), output({"train", "--help"}));
  EXPECT_NE(output({"help", "train"}).find("tessera train"), std::string::npos);
  EXPECT_EQ(output({"version"}), output({"--version"}));
  EXPECT_EQ(output({"-V"}), output({"--version"}));
  work.expect_refused({"help", "trian"}, {"unknown command 'trian'", "did you mean 'train'?"});
}

// Bug put back: --help before an unknown command is a request for help; seen to fail.
TEST(CliUsage, UnknownCommands) {
  const CliWorkspace work;
  expect_no_suggestion(work, {"reconstruct", "--help"},
                       "unknown command 'reconstruct'; there are run, ingest");
  work.expect_refused({"trian", "--help"}, {"unknown command 'trian'", "did you mean 'train'?"});
  work.expect_refused({"eval", "x"}, {"unknown command 'eval'", "did you mean 'evaluate'?"});
  expect_no_suggestion(work, {"-v"}, "unknown option '-v'; see tessera --help");
  expect_no_suggestion(work, {"--verbose", "--help"}, "unknown option '--verbose'");
  work.expect_refused({""}, {"unknown command ''"});
  const ChildResult none = work.run({});
  EXPECT_EQ(none.exit_code, 2);
  for (const char* part : {"no command", "tessera run CAPTURE -o OUT", "tessera --help"})
    EXPECT_NE(none.err.find(part), std::string::npos) << none.err;
}

// Bug put back: no advice; seen to fail. Distances and prefixes: train_options_test.cpp.
TEST(CliUsage, UnknownOptions) {
  const CliWorkspace work;
  const auto refused = [&](std::vector<std::string> arguments, const std::string& part) {
    arguments.insert(arguments.begin() + 1, {work.at("capture"), "-o", work.at("x")});
    work.expect_refused(arguments, {part});
  };
  refused({"train", "--lr", "0.01"}, "unknown option '--lr'; did you mean one of --lr-node-");
  refused({"train", "--iter", "5"}, "did you mean '--iterations'?");
  refused({"train", "--max-gausians", "5"}, "did you mean '--max-gaussians'?");
  refused({"run", "-p", "fast"}, "unknown option '-p'; did you mean '--preset'?");
  refused({"run", "--resume"}, "'--resume'; run resumes by itself: repeat the command");
  refused({"run", "--stop-after", "5"}, "'--stop-after'; it is an option of train");
  refused({"train", "--zzz"}, "unknown option '--zzz'; see tessera train --help");
  refused({"train", "--output", "x"}, "did you mean '--out'?");
  refused({"train", ""}, "'' is one argument too many");
  work.expect_refused({"train", "x", "out"},
                      {"'out' is one argument too many", "write -o out, or"});
  work.expect_refused({"export", "x", "-o", "y", "--format", "mp4"},
                      {"for a video: tessera render RUN --path orbit --mp4"});
  expect_no_suggestion(work, {"train", "x", "-o", "y", "--preset", "x"}, "there are fast, ");
  expect_no_suggestion(work, {"export", "x", "-o", "y", "--format", "dxf"}, "there are tessera, ");
  EXPECT_FALSE(fs::exists(work / "x"));
}

// Bug put back: the parser's own "Could not convert"; seen to fail.
TEST(CliUsage, ValuesThatCannotBeRead) {
  const CliWorkspace work;
  work.expect_refused({"train", "x", "-o", "y", "--threads", "many"},
                      {"tessera train: --threads is 'many', expected a whole number; see"});
  work.expect_refused({"bench", "x", "--opacity", "half"},
                      {"--opacity is 'half', expected a number"});
  work.expect_refused({"info", "x", "--json=maybe"}, {"--json is 'maybe', expected no value"});
  work.expect_refused({"train", "x", "-o"}, {"tessera train: --out needs a value; see"});
}

// Bug put back: what is no folder is said not to be there; seen to fail.
TEST(CliUsage, AFileWhereAFolderIsExpected) {
  const CliWorkspace work;
  work.write("clip.mp4", "");
  const std::string file = work.at("clip.mp4");
  const std::vector<std::string> parts{"clip.mp4: is a video; ", "tessera run FOLDER -o OUT"};
  for (const char* command : {"run", "train", "batch"})
    work.expect_refused({command, file, "-o", work.at("out")}, parts);
  work.expect_refused({"bench", file}, parts);
#if TESSERA_HAS_INGEST
  work.expect_refused({"ingest", file, "-o", work.at("out")}, parts);
  work.expect_refused({"doctor", file}, parts);
#endif
  work.write("model.ply", "");
  work.expect_refused({"train", work.at("model.ply"), "-o", work.at("out")},
                      {"model.ply: is a model or a point cloud", "tessera info"});
  work.write("notes", "");
  work.expect_refused({"run", work.at("notes"), "-o", work.at("out")},
                      {"notes: is a file; pass the folder that holds it"});
  EXPECT_FALSE(fs::exists(work / "out")) << "what was written before the refusal";
  work.expect_refused({"run", work.at("nowhere"), "-o", work.at("out")},
                      {"nowhere: no such folder; check the path"});
  fs::create_directory(work / "empty");
  work.expect_refused({"run", work.at("empty"), "-o", work.at("out")}, {"empty", "no videos"});
  work.expect_refused({"run", work.at("capture"), "-o", work.at("out"), "--frames", "0"},
                      {"--frames is 0"});
  EXPECT_FALSE(fs::exists(work / "out"));
}

// Bug put back: run_folder_of returns OUT itself; seen to fail.
TEST(CliUsage, TheFolderOfARunStandsForItsModel) {
  const CliWorkspace work;
  run_once(work);
  const std::string out = work.at("out"), model = (work / "out/run/model.ply").string();
  EXPECT_EQ(work.run_json({"evaluate", out})["model"], model);
  EXPECT_EQ(work.run_json({"export", out, "-o", work.at("frames"), "--frames", "1"})["model"],
            model);
  const std::vector<std::string> orbit{"--path", "orbit", "--seconds", "0.1", "--size", "16x16"};
  std::vector<std::string> render{"render", out, "-o", work.at("views")};
  render.insert(render.end(), orbit.begin(), orbit.end());
  EXPECT_EQ(work.run_json(render)["model"], model);
  EXPECT_EQ(work.run_json({"info", out})["kind"], "run");
}

#if TESSERA_HAS_INGEST
// Bug put back: the scene beside the run is not searched for; seen to fail.
TEST(CliUsage, AMovedOutputHasItsScene) {
  const CliWorkspace work;
  run_once(work, {"--scale", "0.5"});  // which needs a prepared scene of its own
  ASSERT_TRUE(fs::exists(work / "out/scene/transforms.json"));
  fs::rename(work / "out", work / "moved");
  const std::string scene = (work / "moved/scene").string();
  for (const char* model : {"moved", "moved/run", "moved/run/model.ply"})
    EXPECT_EQ(work.run_json({"evaluate", work.at(model)})["scene"], scene) << model;
  fs::rename(work / "moved/scene", work / "elsewhere");
  work.expect_refused({"evaluate", work.at("moved")}, {"out/scene is gone", "pass --scene"});
}
#endif

// Bugs put back, each seen to fail: the model read first; no check of the time.
TEST(CliUsage, ArgumentsAreCheckedBeforeTheModelIsRead) {
  const CliWorkspace work;
  const auto refused = [&](std::vector<std::string> arguments, const std::string& part) {
    arguments.insert(arguments.begin() + 1, work.at("nowhere"));
    work.expect_refused(arguments, {part});
  };
  refused({"render", "-o", "x", "--path", "orbit", "--size", "1080p"}, "--size is '1080p'");
  refused({"render", "-o", "x", "--path", "circle"}, "--path 'circle'");
  refused({"render", "-o", "x", "--path", "orbit", "--rate", "-1"}, "--rate is -1");
  refused({"render", "-o", "x", "--path", "orbit", "--time", "5"}, "--time is 5, expected 0");
  refused({"render", "-o", "x", "--cameras", "c", "--split", "tests"}, "unknown split 'tests'");
  refused({"render", "-o", "x", "--cameras", "c", "--background", "red"}, "background 'red'");
  refused({"evaluate", "--split", "tests"}, "unknown split 'tests'");
  refused({"evaluate", "--background", "red"}, "background 'red'");
  refused({"evaluate", "--moving-masks", "masks"}, "masks: no such folder");
}

// Bugs put back, each seen to fail: neither said.
TEST(CliUsage, ReportsUncountedAndUnreadOptions) {
  const CliWorkspace work;
  fs::create_directories(work / "capture/sparse/0");
  work.write("capture/sparse/0/cameras.txt", "");
  const ChildResult trained = work.train("run", {"--iterations", "2", "--max-bytes", "100000"});
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  EXPECT_NE(trained.err.find("read as transforms_train.json; sparse/0 is there, too"),
            std::string::npos)
      << trained.err;
  EXPECT_EQ(trained.err.find("MB of player") != std::string::npos, carries_pages()) << trained.err;
}

// Bugs put back, each seen to fail: `options` taken for an option; the parser's reason left out;
// the file not named.
TEST(CliUsage, ConfigFiles) {
  const CliWorkspace work;
  ASSERT_EQ(work.train("first", {"--seed", "7", "--sh-degree", "1"}).exit_code, 0);
  const ChildResult again = work.run({"train", work.at("capture"), "-o", work.at("again"),
                                      "--config", work.at("first/config.json")});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(json::parse(work.read("again/config.json"))["options"],
            json::parse(work.read("first/config.json"))["options"]);
  const auto refused = [&](const char* text, const std::vector<std::string>& parts) {
    work.write("my.json", text);
    work.expect_refused(work.train_arguments("run", {"--config", work.at("my.json")}), parts);
  };
  refused("{\"seed\": 3,}", {"my.json", "not valid JSON", "line 1, column 12"});
  refused("{\"sed\": 3}", {"my.json: unknown option 'sed'; did you mean 'seed'?"});
  refused("{\"seed\": \"x\"}", {"my.json: option 'seed' is \"x\", expected a whole number"});
  refused("[3]", {"my.json: expected a JSON object of option: value"});
  work.expect_refused(work.train_arguments("run", {"--iterations", "1e9999"}), {"\"1e9999\""});
  EXPECT_FALSE(fs::exists(work / "run"));
}

// Bug put back: OpenImageIO linked, whose libraries every start of the program loads; seen to fail.
TEST(CliUsage, LibrariesOfImagesAreNotLoadedAtTheStart) {
  const CliWorkspace work;
  ::setenv("LD_TRACE_LOADED_OBJECTS", "1", 1);
  const ChildResult libraries = work.run({"version"});
  ::unsetenv("LD_TRACE_LOADED_OBJECTS");
  EXPECT_NE(libraries.out.find("libc.so"), std::string::npos) << libraries.err;
  EXPECT_EQ(libraries.out.find("OpenImageIO"), std::string::npos);
}

}  // namespace
}  // namespace tessera::testing
