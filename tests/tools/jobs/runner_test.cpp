// A list of jobs whose program is a script that notes when it begins and ends.
#include "tools/jobs/runner.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "ingest/files/atomic_file.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Names = std::vector<std::string>;

/// `note NAME [SHELL]`: does what SHELL says between the two notes.
constexpr const char* kScript = R"(#!/bin/sh
name=$2
echo "begin $name $CUDA_VISIBLE_DEVICES" >> notes
eval "${3:-true}" || exit
echo "end $name" >> notes
echo "{\"is\": \"$name\"}"
)";

class Jobs : public ::testing::Test {
 protected:
  Jobs() {
    write_text_file(folder_.program, kScript);
    fs::permissions(folder_.program, fs::perms::owner_all);
  }
  static Job job(const std::string& name, const Names& needs = {}, const std::string& shell = "") {
    Job job{name, {"note", name}, needs, {}, {}, {}, {}};
    if (!shell.empty()) job.words.push_back(shell);
    return job;
  }
  JobsOutcome run(const std::vector<Job>& jobs, const JobSlots& slots = {{}, 8, 1000}) {
    JobsObserver observer;
    observer.on_end = [&](const Job& job, const JobOutcome& outcome) {
      if (outcome.exit_code != 0) failures_[job.name] = outcome.message;
    };
    observer.signal = [this] { return signal_.load(); };
    return run_jobs(jobs, folder_, slots, observer);
  }
  /// "begin a ", "end a", … since they were asked for last.
  Names notes() {
    std::ifstream file(scratch_ / "notes");
    Names lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    fs::remove(scratch_ / "notes");
    return lines;
  }
  /// Most jobs at work at once.
  static int most_at_once(const Names& notes) {
    int now = 0, most = 0;
    for (const std::string& line : notes)
      most = std::max(most, now += line.starts_with("begin") ? 1 : -1);
    return most;
  }

  const ScratchFolder scratch_;
  const JobFolder folder_{scratch_.path(), scratch_ / "program"};
  std::map<std::string, std::string> failures_;
  std::atomic<int> signal_ = 0;
};

// Bugs put back, each seen to fail: what is done runs again; other inputs or a repeat of what it
// needs count as done. Finds also: a lost file.
TEST_F(Jobs, RunInOrderAndOnceAndAgainWhereSomethingChanged) {
  std::vector<Job> jobs{job("a"), job("b", {"a"}), job("c", {"b"}), job("d", {"a"})};
  EXPECT_TRUE(run(jobs, {{}, 1, 1000}).all_done());
  EXPECT_EQ(notes(), (Names{"begin a ", "end a", "begin b ", "end b", "begin c ", "end c",
                            "begin d ", "end d"}));
  EXPECT_EQ(read_record(folder_, "b")["result"]["is"], "b");
  EXPECT_GE(read_record(folder_, "b")["seconds"], 0.0);
  EXPECT_TRUE(run(jobs).all_done());
  EXPECT_EQ(notes(), Names{});
  jobs[1].inputs = "other options";
  EXPECT_TRUE(run(jobs).all_done());
  EXPECT_EQ(notes(), (Names{"begin b ", "end b", "begin c ", "end c"}));
  jobs[3].inputs = "another capture";
  EXPECT_TRUE(run(jobs).all_done());
  EXPECT_EQ(notes(), (Names{"begin d ", "end d"}));
  jobs[2].words.emplace_back("true");
  jobs[2].output = "made/c.json";
  EXPECT_TRUE(run(jobs).all_done());
  EXPECT_EQ(notes(), (Names{"begin c ", "end c"})) << "its file is not there";
  EXPECT_EQ(json::parse(read_text_file(scratch_ / "made/c.json"))["is"], "c");
  jobs[2].words.emplace_back("more");
  EXPECT_TRUE(run(jobs).all_done());
  EXPECT_EQ(notes(), Names{}) << "the same by other words";
  fs::remove(folder_.record("b"));
  EXPECT_TRUE(run({jobs[0], jobs[1]}).all_done());
  notes();
  EXPECT_TRUE(run(jobs).all_done());
  EXPECT_EQ(notes(), (Names{"begin c ", "end c"})) << "what it needs was done again";
  write_job_list(jobs, folder_);
  EXPECT_EQ(read_job_list(folder_).size(), 4u);
  EXPECT_EQ(read_job_list(folder_)[1].words, jobs[1].words);
  EXPECT_EQ(read_job_list(folder_)[2].needs, Names{"b"});
}

// Bugs put back, each seen to fail: one after the other; more than there is room for; a job that
// needs more than there is never started; two on one card.
TEST_F(Jobs, RunAtOnceWhereThereIsRoom) {
  std::vector<Job> jobs;
  for (const char* name : {"a", "b", "c", "d"}) jobs.push_back(job(name, {}, "sleep 0.3"));
  EXPECT_TRUE(run(jobs, {{}, 2, 1000}).all_done());
  EXPECT_EQ(most_at_once(notes()), 2);
  for (Job& each : jobs) each.inputs = "again", each.uses.memory_mb = 400;
  jobs[0].uses.memory_mb = 5000;
  EXPECT_TRUE(run(jobs, {{}, 8, 1000}).all_done());
  EXPECT_TRUE(is_done(jobs[0], folder_));
  EXPECT_TRUE(is_done(jobs[3], folder_));
  const Names all = notes();
  EXPECT_EQ(all[1], "end a") << "nothing beside it";
  EXPECT_EQ(most_at_once(all), 2);
  for (Job& each : jobs) each.inputs = "on cards", each.uses = {1, 1, 0};
  EXPECT_TRUE(run(jobs, {{0, 1}, 8, 1000}).all_done());
  std::map<std::string, int> cards;
  for (const std::string& line : notes())
    if (line.starts_with("begin")) ++cards[line.substr(8)];
  EXPECT_EQ(cards, (std::map<std::string, int>{{"0", 2}, {"1", 2}}));
}

// Bugs put back, each seen to fail: the first failure ends the list; what needs a lost job runs.
TEST_F(Jobs, AFailureCostsWhatNeedsItAlone) {
  const std::vector<Job> jobs{
      job("a", {}, "echo 'tessera: no such folder' >&2; echo more >&2; exit 2"),
      job("b", {"a"}),
      job("c", {"b"}),
      job("d"),
      job("e", {}, "kill -9 $$"),
      job("f", {}, "echo no result; exec true")};
  const JobsOutcome outcome = run(jobs);
  EXPECT_FALSE(outcome.all_done());
  Names failed = outcome.failed;
  std::sort(failed.begin(), failed.end());
  EXPECT_EQ(failed, (Names{"a", "e", "f"}));
  EXPECT_EQ(outcome.skipped, (Names{"b", "c"}));
  EXPECT_EQ(failures_["a"], "tessera: no such folder");
  EXPECT_EQ(failures_["e"], "was killed");
  EXPECT_EQ(failures_["f"], "has ended without a result");
  const json record = read_record(folder_, "a");
  EXPECT_EQ(record["exit_code"], 2);
  EXPECT_EQ(record["done"], false);
  EXPECT_NE(read_text_file(folder_.log("a")).find("more"), std::string::npos);
  notes();
  run(jobs);
  const Names again = notes();
  EXPECT_EQ(std::count(again.begin(), again.end(), "begin d "), 0) << "done before";
  EXPECT_EQ(std::count(again.begin(), again.end(), "begin a "), 1) << "is tried again";
}

// Bugs put back, each seen to fail: not tried again; tried again beside others; for ever.
TEST_F(Jobs, OneOutOfMemoryIsTriedOnceMoreAlone) {
  const std::string greedy =
      "if [ -e once ]; then sleep 0.3; else : > once; echo 'CUDA error: Out of memory' >&2; exit "
      "1; fi";
  EXPECT_TRUE(run({job("a", {}, greedy), job("b", {}, "sleep 0.5"), job("c", {"b"})}).all_done());
  const Names all = notes();
  const auto second =
      std::find(std::find(all.begin(), all.end(), "begin a ") + 1, all.end(), "begin a ");
  ASSERT_NE(second, all.end());
  EXPECT_EQ(*(second + 1), "end a") << "nothing beside it";
  EXPECT_EQ(run({job("d", {}, "echo out of memory >&2; exit 1")}).failed, Names{"d"});
}

// Bugs put back, each seen to fail: the jobs that run are killed, or left alone; a further job
// starts; what was stopped counts as done.
TEST_F(Jobs, ASignalIsPassedOnOnceAndNothingElseStarts) {
  const std::string trained =
      "trap 'echo saved >> notes; exit 75' TERM; while :; do sleep 0.05; done";
  std::thread stops([&] {
    while (!fs::exists(scratch_ / "notes"))
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    signal_ = SIGTERM;
  });
  const JobsOutcome outcome = run({job("a", {}, trained), job("b", {}, "true")}, {{}, 1, 1000});
  stops.join();
  EXPECT_TRUE(outcome.stopped);
  EXPECT_EQ(notes(), (Names{"begin a ", "saved"}));
  EXPECT_EQ(read_record(folder_, "a")["exit_code"], 75);
  signal_ = 0;
  EXPECT_TRUE(run({job("a"), job("b", {}, "true")}).all_done());
}

// Bug put back: a job that an earlier start has in work is begun beside it; seen to fail.
TEST_F(Jobs, OneThatAKilledProgramHasLeftAtWorkIsWaitedFor) {
  fs::create_directories(folder_.log("a").parent_path());
  const int held = ::open(folder_.log("a").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  ASSERT_EQ(::flock(held, LOCK_EX), 0);
  std::thread ends([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    std::ofstream(scratch_ / "notes", std::ios::app) << "end of the earlier start\n";
    ::close(held);
  });
  EXPECT_TRUE(run({job("a")}).all_done());
  ends.join();
  EXPECT_EQ(notes(), (Names{"end of the earlier start", "begin a ", "end a"}));
}

}  // namespace
}  // namespace tessera::testing
