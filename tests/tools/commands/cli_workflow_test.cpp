// `tessera batch`: the files for its engine, the call of the engine and the handling of its exit;
// an invalid configuration gives one line and exit code 2 before anything runs. The engine is
// replaced by a script.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class CliWorkflow : public ::testing::Test {
 protected:
  CliWorkflow() : path_(std::getenv("PATH")) {
    fs::create_directory(work / "bin");
    engine("exit 0");
    ::setenv("PATH", (work.at("bin") + ":" + path_).c_str(), 1);
  }
  ~CliWorkflow() override { ::setenv("PATH", path_.c_str(), 1); }

  /// A script called snakemake that writes its words to ARGUMENTS, then does `what`.
  void engine(const std::string& what, const std::string& name = "snakemake") const {
    work.write("bin/" + name, "#!/bin/sh\nPATH=" + path_ +
                                  "\nfor word; do echo \"$word\"; done > " + work.at("arguments") +
                                  "\ncp " + work.at("out") + "/*.yaml " + work.at("kept.yaml") +
                                  "\n" + what + "\n");
    fs::permissions(work / "bin" / name, fs::perms::owner_all);
  }
  /// No program is there but those of bin/.
  void without_snakemake() const {
    fs::remove(work / "bin/snakemake");
    ::setenv("PATH", work.at("bin").c_str(), 1);
  }
  std::vector<std::string> engine_words() const {
    std::vector<std::string> words;
    std::istringstream lines(work.read("arguments"));
    for (std::string line; std::getline(lines, line);) words.push_back(line);
    return words;
  }
  std::vector<std::string> arguments(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"batch", work.at("capture"), "-o", work.at("out")};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  /// Also of a dry run, whose engine keeps what it is given.
  json yaml() const { return json::parse(work.read("kept.yaml")); }
  /// One line, exit code 2, and the engine was not called.
  void refused(const std::vector<std::string>& words, const std::vector<std::string>& parts) const {
    work.expect_refused(words, parts);
    EXPECT_FALSE(fs::exists(work / "arguments"));
  }
  /// Lines of a script that leave the folder of a run that is done.
  std::string done(const std::string& preset, int seed) const {
    const std::string run = work.at("out/runs/capture/" + preset + "/seed-" + std::to_string(seed));
    return "mkdir -p " + run + "; echo '{\"psnr\": 20}' > " + run + "/metrics.json\n";
  }

  CliWorkspace work;

 private:
  std::string path_;
};

bool has_words(const std::vector<std::string>& words, const std::vector<std::string>& part) {
  return std::search(words.begin(), words.end(), part.begin(), part.end()) != words.end();
}

// Bugs put back: a file of --masks left relative to where the command was typed; options of the
// training among ingest's; seen to fail.
TEST_F(CliWorkflow, BatchYamlHasTheGivenOptions) {
  fs::create_directory(work / "masks");
  const ChildResult result = work.run(arguments({"--preset",
                                                 "fast,best",
                                                 "--preset",
                                                 "balanced",
                                                 "--seeds",
                                                 "1,7",
                                                 "--budgets",
                                                 "500,900",
                                                 "--exports",
                                                 "ply,page",
                                                 "--iterations",
                                                 "50",
                                                 "--deterministic",
                                                 "true",
                                                 "--scale",
                                                 "0.5",
                                                 "--strict",
                                                 "--masks",
                                                 fs::relative(work / "masks").string(),
                                                 "--cameras",
                                                 "a,b",
                                                 "--threads",
                                                 "3",
                                                 "--gpus",
                                                 "0",
                                                 "--dry-run"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json yaml = this->yaml();
  ASSERT_EQ(yaml["scenes"].size(), 1u);
  EXPECT_EQ(yaml["scenes"][0]["name"], "capture");
  EXPECT_EQ(yaml["scenes"][0]["path"], work.at("capture"));
  EXPECT_EQ(yaml["scenes"][0]["ingest"],
            json::parse(R"(["--scale", "0.5", "--cameras", "a,b", "--strict", "--masks", ")" +
                        work.at("masks") + "\"]"));
  EXPECT_EQ(yaml["presets"][1], json::parse(R"({"name": "best", "preset": "best",
                                                "options": {"iterations": "50"}})"));
  EXPECT_EQ(yaml["presets"].size(), 3u);
  EXPECT_EQ(yaml["seeds"], json({1, 7}));
  EXPECT_EQ(yaml["budgets"], json({500, 900}));
  EXPECT_EQ(yaml["exports"], json({"ply", "page"}));
  EXPECT_EQ(yaml["deterministic"], true);
  EXPECT_EQ(yaml["threads"], 3);
  EXPECT_EQ(yaml["tessera"], TESSERA_PROGRAM);
}

// Bugs put back: a capture that is named and matched is two scenes; a folder without a capture ends
// the batch; seen to fail.
TEST_F(CliWorkflow, DatasetsAreCapturesFoldersAndGlobs) {
  fs::create_directories(work / "many");
  for (const char* name : {"many/b", "many/a", "other"})
    fs::copy(work / "capture", work / name, fs::copy_options::recursive);
  fs::create_directory(work / "many/notes");
  const ChildResult result = work.run({"batch", work.at("many"), work.at("o*r"), work.at("many/a"),
                                       "-o", work.at("out"), "--dry-run"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::string names;
  const json yaml = this->yaml();
  for (const json& scene : yaml["scenes"]) names += scene["name"].get<std::string>() + " ";
  EXPECT_EQ(names, "a b notes other ") << "what is no capture fails alone, later";
  EXPECT_EQ(yaml["presets"], json::array({"balanced"})) << "a name where there are no options";
}

// Bug put back: the engine's folder set by its working folder, not by --directory; seen to fail.
TEST_F(CliWorkflow, CallsTheEngineAsAPersonCould) {
  engine(done("fast", 1));
  const ChildResult result = work.run(arguments({"--preset", "fast"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::vector<std::string> words = engine_words();
  EXPECT_TRUE(has_words(words, {"--snakefile", work.at("out/workflow/Snakefile")}));
  EXPECT_TRUE(has_words(words, {"--directory", work.at("out")}));
  EXPECT_TRUE(has_words(words, {"--keep-going", "--rerun-incomplete"}));
  EXPECT_TRUE(has_words(words, {"--profile", work.at("out/workflow/profiles/local")}));
  EXPECT_TRUE(has_words(words, {"--cores"}));
  EXPECT_TRUE(has_words(words, {"--resources", "gpu=1"})) << "one training at a time on one card";
  EXPECT_NE(result.err.find("snakemake --snakefile " + work.at("out/workflow/Snakefile")),
            std::string::npos)
      << result.err;
  EXPECT_TRUE(fs::exists(work / "out/workflow/Snakefile"));
  EXPECT_FALSE(fs::exists(work / "out/workflow/CMakeLists.txt"));
  EXPECT_NE(result.out.find("1 of 1 runs done"), std::string::npos) << result.out;

  const std::string before = work.read("out/batch.yaml");
  const ChildResult other = work.run(arguments({"--preset", "best", "--dry-run"}));
  EXPECT_EQ(other.exit_code, 0) << other.err;
  EXPECT_EQ(work.read("out/batch.yaml"), before) << "a dry run changes nothing";
  const ChildResult again = work.run({"batch", "-o", work.at("out"), "--dry-run"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_TRUE(has_words(engine_words(), {"--dry-run"}));
  EXPECT_EQ(work.read("out/batch.yaml"), before);
}

// Bug put back: the exit code is the engine's alone; seen to fail.
TEST_F(CliWorkflow, TheLastLineReportsTheOutcome) {
  const std::string asked =
      "{\"scenes\": [{\"name\": \"capture\"}], \"variants\": [{\"name\": \"fast\"}], "
      "\"seeds\": [1, 2, 3]}";
  engine(done("fast", 1) + "echo '" + asked + "' > " + work.at("out/asked.json") + "; mkdir -p " +
         work.at("out/failures") +
         "; echo '{\"scene\": \"capture\", \"rule\": \"train\", \"preset\": \"fast\", \"seed\": 2, "
         "\"exit_code\": 1, \"message\": \"loss is not finite\"}' > " +
         work.at("out/failures/one.json") + "\nexit 0");
  const ChildResult result = work.run(arguments({"--preset", "fast", "--seeds", "1,2,3"}));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.out.find("1 of 3 runs done, 1 failed, 1 not run; 0 of 1 scenes complete"),
            std::string::npos)
      << result.out;
  for (const char* place : {"out/report/index.html", "out/failures"})
    EXPECT_NE(result.out.find(work.at(place)), std::string::npos) << result.out;
  EXPECT_NE(result.err.find("batch: capture, fast, seed 1 done"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("seed 2 (exit 1): loss is not finite"), std::string::npos);
  engine(done("fast", 2) + done("fast", 3) + "rm " + work.at("out/failures/one.json") + "; exit 3");
  const ChildResult other = work.run(arguments({"--preset", "fast", "--seeds", "1,2,3"}));
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_NE(other.out.find("exit code 3"), std::string::npos) << other.out;
}

// Bug put back: one_by_one.py is called with Snakemake's words; seen to fail.
TEST_F(CliWorkflow, WithoutSnakemakeTheJobsRunOneAfterTheOther) {
  without_snakemake();
  engine(done("fast", 1), "python3");
  const ChildResult result = work.run(arguments({"--preset", "fast", "--jobs", "1"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::vector<std::string> words{work.at("out/workflow/one_by_one.py"), "--directory",
                                       work.at("out")};
  EXPECT_EQ(engine_words(), words);
  EXPECT_TRUE(fs::exists(words[0]));
  EXPECT_NE(result.err.find("snakemake is not installed: the jobs run one after the other"),
            std::string::npos)
      << result.err;
  EXPECT_NE(result.out.find("1 of 1 runs done"), std::string::npos) << result.out;
  work.run(arguments({"--preset", "best", "--dry-run"}));
  EXPECT_TRUE(has_words(engine_words(), {"--dry-run", "--file", "batch.dry-run.yaml"}));
}

// Bug put back: every end of the engine but 0 is a failure of scenes; seen to fail.
TEST_F(CliWorkflow, WhatTheWorkflowRefusesIsBadInput) {
  engine("echo \"tessera: presets: unknown preset 'fats'\" >&2; exit 2");
  const ChildResult result = work.run(arguments());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
}

// Bug put back: the signal is sent to the engine alone, not to its jobs; seen to fail.
TEST_F(CliWorkflow, AnInterruptReachesTheJobs) {
  // the job is a child of the engine
  work.write("job", "#!/bin/sh\ntrap 'echo saved > " + work.at("saved") + "; exit 130' INT\n: > " +
                        work.at("started") + "\nwhile true; do sleep 0.05; done\n");
  fs::permissions(work / "job", fs::perms::owner_all);
  engine("trap : INT\n" + work.at("job") + "\nexit 1");
  ChildProcess batch(arguments(), work.path());
  ASSERT_TRUE(batch.wait_until([&] { return fs::exists(work / "started"); }));
  batch.send(SIGINT);
  const ChildResult result = batch.wait();
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_TRUE(fs::exists(work / "saved"));
  EXPECT_NE(result.out.find("run the same command again"), std::string::npos) << result.out;
}

// Bugs put back, one each: the name of a preset is not looked up; an empty glob is an empty batch;
// names are not compared; the folder's error passes as a failure of the batch; the engine's absence
// is exit code 127; --jobs and --profile are passed over without Snakemake; each seen to fail.
TEST_F(CliWorkflow, ABadConfigurationIsOneLine) {
  refused(arguments({"--preset", "fats"}), {"'fats'", "fast"});
  refused(arguments({"--iterations", "many"}), {"iterations", "many"});
  refused(arguments({"--exports", "movie"}), {"--exports", "'movie'", "there are"});
  refused(arguments({"--seeds", "2,2"}), {"--seeds has 2 twice"});
  refused(arguments({"--seed", "2"}), {"use --seeds"});
  refused(arguments({"--budgets", "9", "--max-gaussians", "9"}), {"--budgets", "not both"});
  refused(arguments({"--profile", "moon"}), {"--profile moon", "config.yaml"});
  refused({"batch", work.at("no*where"), "-o", work.at("out")}, {"no*where", "matches no folder"});
  refused({"batch", work.at("nowhere"), "-o", work.at("out")}, {"nowhere", "no such folder"});
  refused({"batch", work.at("bin"), "-o", work.at("out")}, {work.at("bin"), "name the folder"});
  refused({"batch", "-o", work.at("empty")}, {"batch.yaml", "name the captures"});
  for (const char* folder : {"hand", "a profile"}) fs::create_directory(work / folder);
  work.write("hand/batch.yaml", "presets: [fast]  # mine\n");
  refused({"batch", work.at("capture"), "-o", work.at("hand")}, {"written by hand", "leave out"});
  work.write("a profile/config.yaml", "jobs: 1\n");
  refused(arguments({"--profile", work.at("a profile")}), {"has a space"});
  fs::create_directory(work / "other");
  fs::copy(work / "capture", work / "other/capture", fs::copy_options::recursive);
  refused({"batch", work.at("capture"), work.at("other/capture"), "-o", work.at("out")},
          {"two captures are named 'capture'", work.at("other/capture"), "rename"});
  for (const char* folder : {"a b", "a_b"})
    fs::copy(work / "capture", work / folder, fs::copy_options::recursive);
  refused({"batch", work.at("a b"), work.at("a_b"), "-o", work.at("out")},
          {"two captures are named 'a_b'", "rename"});
  work.write("file", "");
  refused({"batch", work.at("capture"), "-o", work.at("file/out")}, {"file/out"});
  without_snakemake();
  fs::remove_all(work / "out");
  refused(arguments(), {"python3 is not installed", "apt-get install python3"});
  engine("exit 0", "python3");
  refused(arguments({"--profile", "slurm"}), {"--profile slurm", "apt-get install snakemake"});
  refused(arguments({"--jobs", "2"}), {"--jobs 2", "apt-get install snakemake"});
  EXPECT_FALSE(fs::exists(work / "out")) << "nothing is written that cannot be run";
}

}  // namespace
}  // namespace tessera::testing
