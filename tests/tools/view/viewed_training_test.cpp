// A training with --view: its page stops it, and says how it is resumed. Source:
// docs/reference/player.md.
#include <fcntl.h>
#include <sys/file.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <thread>

#include "tests/tools/commands/cli_workspace.h"
#include "tests/tools/view/http_client.h"
#include "tools/live/live_folder.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Words = std::vector<std::string>;

/// The page of a server, by the address that a program has printed.
class Page {
 public:
  explicit Page(const std::string& printed) {
    static const std::regex kAddress(R"re(http://[^/]*:(\d+)/\?token=([0-9a-f]{32}))re");
    std::smatch match;
    EXPECT_TRUE(std::regex_search(printed, match, kAddress)) << printed;
    if (match.empty()) return;
    port_ = uint16_t(std::stoi(match[1]));
    const std::string host = "localhost:" + match[1].str();
    headers_ = "Host: " + host + "\r\nOrigin: http://" + host +
               "\r\nConnection: close\r\nCookie: tessera_view_" + match[1].str() + "=" +
               match[2].str() + "\r\n";
  }
  json state() const { return json::parse(body(state_answer())); }
  std::string state_answer() const { return send("GET /api/state?seen=0"); }
  std::string report() const { return body(send("GET /api/report")); }
  /// The status.
  int post(const std::string& path) const {
    return std::stoi(send("POST " + path).substr(std::string("HTTP/1.1 ").size()));
  }

 private:
  static std::string body(const std::string& answer) {
    return answer.substr(answer.find("\r\n\r\n") + 4);
  }
  std::string send(const std::string& line) const {
    const HttpClient client(port_);
    client.send(line + " HTTP/1.1\r\n" + headers_ +
                (line.starts_with("POST") ? "Content-Length: 0\r\n" : "") + "\r\n");
    return client.read_all();
  }

  uint16_t port_ = 0;
  std::string headers_;
};

class ViewedTraining : public ::testing::Test {
 protected:
  void SetUp() override {
#if !TESSERA_HAS_VIEW || !TESSERA_HAS_PLAYER
    GTEST_SKIP() << "built without libmicrohttpd or the player";
#endif
    for (const char* name : {"SSH_CONNECTION", "DISPLAY", "WAYLAND_DISPLAY"}) ::unsetenv(name);
  }
  Words command(const std::string& name, const std::string& out, Words more) const {
    Words words = work.train_arguments(out, more);
    words[0] = name;
    return words;
  }
  static std::string id_of(const json& state) {
    return state["alive"] && !state["state"].is_null() ? state["state"]["training"] : json("");
  }
  /// The page of a command with --view, once its training shows something.
  Page shown(ChildProcess& child) const {
    EXPECT_TRUE(child.wait_until([&] { return has(child, "ends the view"); }))
        << child.err_so_far();
    Page page(child.err_so_far());
    EXPECT_TRUE(child.wait_until([&] { return !id_of(page.state()).empty(); }));
    return page;
  }
  static bool has(const ChildProcess& child, const std::string& text) {
    return child.err_so_far().find(text) != std::string::npos;
  }
  /// The state once it has stopped.
  static json stopped(ChildProcess& child, const Page& page) {
    EXPECT_EQ(page.post("/api/stop"), 202);
    json state;
    EXPECT_TRUE(child.wait_until([&] {
      state = page.state();
      return state["resume"] != "";
    })) << child.err_so_far();
    return state;
  }

  CliWorkspace work;
  ScratchFolder scratch;
};

// Finds: the page never learns that its training has stopped; a training that it stops is
// interrupted by hand (130); a browser that is looked for with --no-browser.
TEST_F(ViewedTraining, ItsPageStopsItAndSaysHowItIsResumed) {
  ::setenv("DISPLAY", ":99", 1);
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", work.at("nothing").c_str(), 1);
  const Words words =
      command("train", "run", {"--view", "--no-browser", "--iterations", "1000000"});
  ChildProcess child(words, scratch.path());
  ::setenv("PATH", path.c_str(), 1);
  const Page page = shown(child);
  EXPECT_TRUE(has(child, "view: Ctrl-C stops the training with a checkpoint and ends the view\n"));
  const json state = stopped(child, page);
  const std::string by_hand =
      "tessera train " + work.at("capture") + " -o " + work.at("run") + " --resume";
  EXPECT_EQ(state["resume"], by_hand);
  EXPECT_FALSE(state["complete"]);
  EXPECT_GT(state["stopped"]["step"], 0);
  EXPECT_EQ(state["stopped"]["total"], 1000000);
  const ChildResult ended = child.wait();
  EXPECT_EQ(ended.exit_code, 75) << ended.err;
  EXPECT_EQ(ended.err.find("xdg-open"), std::string::npos) << ended.err;
  EXPECT_NE(ended.out.find("resume with: " + by_hand), std::string::npos) << ended.out;
}

// Finds: the command of the training alone.
TEST_F(ViewedTraining, AWholeRunIsResumedByItsOwnCommand) {
  ChildProcess child(
      command("run", "out", {"--view", "--iterations", "20000", "--densify-until", "0"}),
      scratch.path());
  const Page page = shown(child);
  const std::string resume = stopped(child, page)["resume"];
  EXPECT_NE(resume.find(" run " + work.at("capture") + " -o "), std::string::npos) << resume;
  EXPECT_EQ(resume.find("--view"), std::string::npos) << resume;
  EXPECT_EQ(child.wait().exit_code, 75);
  EXPECT_FALSE(fs::exists(work / "out/run/metrics.json"));
}

// Bug put back: the folder of the clip is taken for the run, so that nothing is there; seen to
// fail.
TEST_F(ViewedTraining, OfAClipInWindowsIsTheWindowThatIsTrained) {
  for (const char* window : {"out/run/windows/0000", "out/run/windows/0001"})
    ASSERT_EQ(work.train(window, {"--iterations", "2"}).exit_code, 0);
  work.write("out/run/windows.json", "{}");
  const OpenFile lock(
      ::open(work.at("out/run/windows/0001/lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  ASSERT_EQ(::flock(lock.descriptor(), LOCK_EX | LOCK_NB), 0);
  ChildProcess view({"view", work.at("out"), "--no-browser"}, scratch.path());
  ASSERT_TRUE(view.wait_until([&] { return has(view, "ends the view; the training continues"); }))
      << view.err_so_far();
  const Page page(view.out_so_far());
  EXPECT_NE(page.report().find("\"curves\""), std::string::npos) << page.report();
}

// Bug put back: the address of a snapshot throws where RUN/live is removed while its path is
// resolved; seen to fail.
TEST_F(ViewedTraining, IsAnsweredWhileItsFilesComeAndGo) {
  ASSERT_EQ(work.train("run", {"--iterations", "2"}).exit_code, 0);
  const fs::path run = work / "run";
  const OpenFile lock(::open((run / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  ASSERT_EQ(::flock(lock.descriptor(), LOCK_EX | LOCK_NB), 0);
  ChildProcess view({"view", run.string(), "--no-browser"}, scratch.path());
  ASSERT_TRUE(view.wait_until([&] { return has(view, "ends the view; the training continues"); }))
      << view.err_so_far();
  const Page page(view.out_so_far());
  std::atomic<bool> ends = false;
  std::thread training([&] {
    const LiveFolder live(run);
    LiveState state;
    state.training = "0";
    for (state.snapshot = 1; !ends; ++state.counter) {
      live.make();
      live.write(state);
      if (state.counter % 2 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      live.remove();
    }
  });
  int64_t with_snapshot = 0;
  const auto latest = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  for (int i = 0; (i < 2000 || with_snapshot == 0) && !HasFailure(); ++i) {
    EXPECT_LT(std::chrono::steady_clock::now(), latest) << "no answer has named a snapshot";
    const std::string answer = page.state_answer();
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 200 ")) << i << ": " << answer;
    with_snapshot += answer.find("live/scene_1.t4d") != std::string::npos;
  }
  ends = true;
  training.join();
}

}  // namespace
}  // namespace tessera::testing
