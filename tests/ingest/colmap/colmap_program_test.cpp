// The program `colmap` as a child process, with substitutes that fail, sleep, are too old or are
// absent.
#include "ingest/colmap/colmap_program.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "ingest/colmap/colmap_workspace.h"
#include "ingest/files/atomic_file.h"
#include "ingest/files/child_process.h"
#include "tests/ingest/colmap/colmap_fixture.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera::testing {
namespace {

const IngestProgress kQuiet = [](std::string_view, int64_t, int64_t) {};

/// A shell script that TESSERA_COLMAP names during the lifetime of this object.
class StandIn {
 public:
  explicit StandIn(const std::string& script) {
    const auto file = folder_ / "my colmap";
    write_bytes(file, "#!/bin/sh\n" + script);
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    ::setenv("TESSERA_COLMAP", file.c_str(), 1);
  }
  ~StandIn() { ::unsetenv("TESSERA_COLMAP"); }
  std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }

 private:
  TemporaryFolder folder_;
};

constexpr const char* kVersion = "[ \"$1\" = help ] && echo 'COLMAP 3.8 -- x' && exit 0\n";

// Catches: a shell in between (the argument would be expanded), stderr left out.
TEST(ChildProcess, PassesArgumentsAsTheyAreAndKeepsWhatIsSaid) {
  const TemporaryFolder folder;
  const std::string odd = "-a b'c\"d $HOME \xc3\xa9;exit 9";
  std::vector<std::string> lines;
  const ChildResult result =
      run_child({{"/bin/sh", "-c", "echo \"$0\"; echo $WORD >&2; exit 3", odd},
                 {{"WORD", "said"}},
                 folder / "log"},
                [&](std::string_view line) {
                  if (!line.empty()) lines.emplace_back(line);
                });
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_EQ(result.last_line, "said");
  EXPECT_EQ(lines, (std::vector<std::string>{odd, "said"}));
  EXPECT_EQ(read_text_file(folder / "log"), odd + "\nsaid\n");
}

// Ctrl-C: progress throws. Catches: only the child killed, not the sleeper that it started.
TEST(ColmapProgram, LeavesNoProcessBehindWhenProgressThrows) {
  const StandIn colmap(std::string(kVersion) + "sleep 60 &\necho $! > \"$2\"\necho busy\nwait\n");
  const TemporaryFolder folder;
  struct Stop {};
  bool stop = false;
  const IngestProgress progress = [&](std::string_view, int64_t, int64_t) {
    if (stop && std::filesystem::exists(colmap / "pid=")) throw Stop();
  };
  const ColmapProgram program(folder / "log", progress);
  stop = true;
  EXPECT_THROW(program.run("mapper", {{(colmap / "pid").string(), ""}}, "doing"), Stop);
  const int sleeper = std::stoi(read_text_file(colmap / "pid="));
  for (int i = 0; i < 50 && ::kill(sleeper, 0) == 0; ++i)  // the process that inherits it reaps it
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const auto status = "/proc/" + std::to_string(sleeper) + "/stat";
  if (::kill(sleeper, 0) == 0) {
    EXPECT_NE(read_text_file(status).find(") Z"), std::string::npos);
  }
}

// Catches: an exit code that is passed over, a message without the log.
TEST(ColmapProgram, FailureNamesCommandLastLineAndLog) {
  const StandIn colmap(std::string(kVersion) + "echo first\necho 'no space left' >&2\nexit 7\n");
  const TemporaryFolder folder;
  const ColmapProgram program(folder / "log", kQuiet);
  expect_input_error([&] { program.run("mapper", {}, "doing"); },
                     {"mapper", "7", "no space left", (folder / "log").string(), "--poses"});
}

// What COLMAP prints where images have no common points, and where something else fails. Bugs put
// back, each seen to fail: the last line of the stack trace taken; any failure taken for this one.
TEST(ColmapProgram, NoCommonPointsAreASentenceAndACheckIsItsReason) {
  const TemporaryFolder folder;
  const auto failure_of = [&](const std::string& printed, int code) {
    const StandIn colmap(std::string(kVersion) + "echo '" + printed + "'\nexit " +
                         std::to_string(code) + "\n");
    const ColmapProgram program(folder / "log", kQuiet);
    try {
      program.run("mapper", {}, "doing");
    } catch (const ColmapFailure& failure) {
      return failure;
    }
    return ColmapFailure("it did not fail", "", "");
  };
  const std::string trace =
      "\n*** Check failure stack trace: ***\n    @     0x55e3344523a1  _start";
  for (const ColmapFailure& failure :
       {failure_of("F20261126 14:38:40.3 136 sfm.cc:473] Check failed: "
                   "bundle_adjuster.Solve(&reconstruction) " +
                       trace,
                   134),
        failure_of("ERROR: failed to create sparse model", 1)}) {
    EXPECT_TRUE(failure.has_no_common_points()) << failure.reason;
    expect_input_error(
        [&] {
          failure.rethrow({"cam00", "cam01"}, "film more");
        },
        {"COLMAP found no common points in cam00, cam01; film more; its log: " +
         (folder / "log").string()});
  }
  const ColmapFailure other =
      failure_of("F2026 1 a.cc:4] Check failed: a == b (1 vs. 2)" + trace, 134);
  EXPECT_FALSE(other.has_no_common_points());
  expect_input_error(
      [&] {
        other.rethrow({"cam00", "cam01"}, "film more");
      },
      {"colmap mapper failed (exit code 134): Check failed: a == b (1 vs. 2); "});
}

// Catches: a version that is ignored; a comparison as text (3.10 < 3.6).
TEST(ColmapProgram, OldVersionsAreRefusedNewOnesHaveTheirOptions) {
  const TemporaryFolder folder;
  {
    const StandIn colmap("echo 'COLMAP 3.5 -- x'\n");
    expect_input_error([&] { ColmapProgram(folder / "log", kQuiet); }, {"3.5", "3.6", "install"});
  }
  {
    const StandIn colmap("echo 'I am something else'\n");
    expect_input_error([&] { ColmapProgram(folder / "log", kQuiet); }, {"version", "install"});
  }
  for (const auto& [version, option] : std::vector<std::pair<std::string, std::string>>{
           {"3.10", "--SiftExtraction.use_gpu=0"}, {"3.12", "--FeatureExtraction.use_gpu=0"}}) {
    const StandIn colmap("[ \"$1\" = help ] && echo 'COLMAP " + version + "'\necho \"$@\"\n");
    const ColmapProgram program(folder / version, kQuiet);
    EXPECT_EQ(program.version(), version);
    program.extract_features({}, 1);
    EXPECT_NE(read_text_file(folder / version).find(option), std::string::npos);
  }
}

// Bugs put back: no total for steps that are counted in the lines; steps beyond a stated total
// counted on; each seen to fail.
TEST(ColmapProgram, CountsOfItsLinesAreProgress) {
  const StandIn colmap(std::string(kVersion) +
                       "for i in 1 2 3 4; do echo \"Matching block [1/2, $i/2] in 0.1s\"; done\n");
  const TemporaryFolder folder;
  std::vector<std::pair<int64_t, int64_t>> seen;
  const IngestProgress progress = [&](std::string_view what, int64_t done, int64_t total) {
    if (what == "doing" && (seen.empty() || seen.back() != std::pair(done, total)))
      seen.emplace_back(done, total);
  };
  const ColmapProgram program(folder / "log", progress);
  program.run("exhaustive_matcher", {}, "doing", "Matching ");
  EXPECT_EQ(seen,
            (std::vector<std::pair<int64_t, int64_t>>{{0, 0}, {1, 4}, {2, 4}, {3, 4}, {4, 4}}));
  seen.clear();
  program.run("feature_extractor", {}, "doing", "Matching ", 3);
  EXPECT_EQ(seen, (std::vector<std::pair<int64_t, int64_t>>{{0, 3}, {1, 3}, {2, 3}, {3, 3}}));
}

// The stand-in does what glog does. Bug put back: the folder left to glog's own default, the one
// for temporary files; seen to fail, as with the real program.
TEST(ColmapProgram, LogFilesStayBesideTheLog) {
  const StandIn colmap(std::string(kVersion) + "echo said > \"${GLOG_log_dir:-/nowhere}/INFO\"\n");
  const TemporaryFolder folder;
  const ColmapProgram program(folder / "work/log", kQuiet);
  program.run("mapper", {}, "doing");
  EXPECT_EQ(read_text_file(folder / "work/glog/INFO"), "said\n");
}

TEST(ColmapProgram, AbsentProgramGivesTheNameOfThePackage) {
  const TemporaryFolder folder;
  ::setenv("TESSERA_COLMAP", "/nowhere/colmap", 1);
  expect_input_error([&] { ColmapProgram(folder / "log", kQuiet); },
                     {"/nowhere/colmap", "TESSERA_COLMAP", "install colmap"});
  ::unsetenv("TESSERA_COLMAP");
}

// Failure mode B1. Catches: the first model taken, as sparse/0 often is the smallest.
TEST(ColmapWorkspace, TakesTheLargestModelAndReportsIt) {
  const TemporaryFolder folder;
  write_colmap_bin(folder / "0", small_colmap_model(3));
  write_colmap_bin(folder / "1", small_colmap_model(12));
  write_colmap_txt(folder / "2", small_colmap_model(5));
  std::vector<std::string> warnings;
  EXPECT_EQ(largest_colmap_model(folder.path(), 20, warnings), folder / "1");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("made 3 models"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[0].find("is used, with 12 of 20 images"), std::string::npos) << warnings[0];
  EXPECT_EQ(largest_colmap_model(folder / "none", 20, warnings), std::filesystem::path());
  EXPECT_EQ(largest_colmap_model(folder.path(), 12, warnings), folder / "1");
  EXPECT_EQ(warnings.size(), 1u) << "the largest has all images";
}

}  // namespace
}  // namespace tessera::testing
