// `tessera view` as a program: its output, the files it serves, its end, and invalid arguments.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <thread>

#include "tests/tools/commands/cli_workspace.h"
#include "tests/tools/view/http_client.h"
#include "tests/tools/windows/cli_windows_fixture.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class CliView : public ::testing::Test {
 protected:
  void SetUp() override {
    ::unsetenv("SSH_CONNECTION");
    ::unsetenv("DISPLAY");
    ::unsetenv("WAYLAND_DISPLAY");
    ::setenv("TMPDIR", work.at("temporary").c_str(), 1);
    fs::create_directory(work / "temporary");
    work.write("site/index.html", "<p>page</p>");
#if !TESSERA_HAS_VIEW
    work.expect_refused({"view", work.at("site")}, {"without libmicrohttpd", "--format html"});
    GTEST_SKIP() << "built without libmicrohttpd";
#endif
  }
  void TearDown() override {
    ::unsetenv("TMPDIR");
  }

  CliWorkspace work;
};

/// The program while it serves.
class Viewing {
 public:
  explicit Viewing(std::vector<std::string> arguments)
      : child_((arguments.insert(arguments.begin(), "view"), arguments), scratch_.path()) {
    EXPECT_TRUE(child_.wait_until([&] { return child_.out_so_far().ends_with("\n"); }))
        << child_.err_so_far();
    std::smatch match;
    const std::string out = child_.out_so_far();
    static const std::regex kAddress(R"re(http://([^/]*):(\d+)/\?token=([0-9a-f]{32}))re");
    EXPECT_TRUE(std::regex_search(out, match, kAddress)) << out;
    if (match.empty()) return;
    host = match[1];
    port = uint16_t(std::stoi(match[2]));
    cookie_ = "Cookie: tessera_view_" + std::to_string(port) + "=" + match[3].str() + "\r\n";
  }

  std::string get(const std::string& path, const std::string& name = "localhost") const {
    const HttpClient client(port);
    client.send("GET " + path + " HTTP/1.1\r\nHost: " + name + "\r\nConnection: close\r\n" +
                cookie_ + "\r\n");
    return client.read_all();
  }
  /// The program does not wait for idle connections, which have 20 s.
  ChildResult end(int signal) {
    const auto begin = std::chrono::steady_clock::now();
    child_.send(signal);
    ChildResult result = child_.wait();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
    return result;
  }

  std::string host;
  uint16_t port = 0;

 private:
  ScratchFolder scratch_;  // several programs at once need a folder each
  ChildProcess child_;
  std::string cookie_;
};

TEST_F(CliView, ServesAFolderUntilASignal) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Viewing viewing({work.at("site")});
    EXPECT_EQ(viewing.host, "127.0.0.1");
    EXPECT_TRUE(viewing.get("/").ends_with("\r\n\r\n<p>page</p>"));
    EXPECT_TRUE(viewing.get("/", "evil.example").starts_with("HTTP/1.1 421 "));
    const ChildResult result = viewing.end(signal);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "view: Ctrl-C ends the view\n");
  }
}

TEST_F(CliView, LeadsToThePlayerOfARun) {
  work.write("out/player/index.html", "<p>player</p>");
  work.write("out/run/log.jsonl", "{}");
  const Viewing viewing({work.at("out")});
  EXPECT_NE(viewing.get("/").find("Location: /player/\r\n"), std::string::npos);
  EXPECT_TRUE(viewing.get("/player/").ends_with("<p>player</p>"));
  EXPECT_TRUE(viewing.get("/run/log.jsonl").starts_with("HTTP/1.1 404 "));
}

TEST_F(CliView, MakesThePageOfAModel) {
#if !TESSERA_HAS_PLAYER
  GTEST_SKIP() << "built without the player";
#endif
  ASSERT_EQ(work.train("run", {"--iterations", "2"}).exit_code, 0);
  ASSERT_EQ(
      work.run({"export", work.at("run"), "-o", work.at("one"), "--format", "tessera", "--single"})
          .exit_code,
      0);
  for (const char* path : {"run", "run/model.ply", "one/scene.t4d"}) {
    Viewing viewing({work.at(path), "--json"});
    EXPECT_NE(viewing.get("/").find("<!doctype html>"), std::string::npos) << path;
    EXPECT_NE(viewing.get("/manifest.json").find("\"blocks\""), std::string::npos) << path;
    const std::string run = viewing.get("/api/run");
    EXPECT_EQ(json::parse(run.substr(run.find("\r\n\r\n")))["kind"], "model");
    const ChildResult result = viewing.end(SIGTERM);
    EXPECT_EQ(json::parse(result.out)["port"], viewing.port);
    for (const auto& entry : fs::directory_iterator(work / "temporary"))
      EXPECT_FALSE(entry.path().filename().string().starts_with("tessera_view_")) << entry.path();
  }
}

#if TESSERA_HAS_VIEW && TESSERA_HAS_PLAYER
// Bug put back: the folder is served as it is; seen to fail.
TEST_F(CliWindows, AreViewedAsAClip) {
  work.run_json(train("run"));
  Viewing viewing({work.at("run"), "--json"});
  EXPECT_NE(viewing.get("/").find("<!doctype html>"), std::string::npos);
  const std::string answer = viewing.get("/manifest.json");
  const size_t body = answer.find("\r\n\r\n");
  ASSERT_NE(body, std::string::npos);
  EXPECT_EQ(json::parse(answer.substr(body))["windows"].size(), 2u);
  EXPECT_EQ(viewing.end(SIGTERM).exit_code, 0);
}
#endif

// Bugs put back: nothing is told of a training that has stopped; one that patience has ended counts
// as stopped; each seen to fail.
TEST_F(CliView, ReportsWhereARunHasStopped) {
#if !TESSERA_HAS_PLAYER
  GTEST_SKIP() << "built without the player";
#endif
  ASSERT_EQ(work.train("stopped", {"--stop-after", "5"}).exit_code, 0);
  Viewing stopped({work.at("stopped")});
  EXPECT_EQ(stopped.end(SIGINT).err,
            "view: Ctrl-C ends the view\nview: " + work.at("stopped") +
                ": stopped after 5 of 20 steps; resume with: tessera train " + work.at("capture") +
                " -o " + work.at("stopped") + " --resume\n");
  ASSERT_EQ(work.train("whole").exit_code, 0);
  work.film_object("six", 6, 32);
  const json patient = work.run_json({"train",
                                      work.at("six"),
                                      "-o",
                                      work.at("patient"),
                                      "--iterations",
                                      "60",
                                      "--init-points",
                                      "300",
                                      "--densify-until",
                                      "0",
                                      "--validation-share",
                                      "0.34",
                                      "--validate-interval",
                                      "3",
                                      "--stop-patience",
                                      "2",
                                      "--lr-scale",
                                      "0.3",
                                      "--lr-mean",
                                      "0.05",
                                      "--lr-mean-final",
                                      "0.05",
                                      "--lr-sh",
                                      "0.3"});
  ASSERT_TRUE(patient["finished"]);
  ASSERT_LT(patient["iterations"], 60);
  for (const char* run : {"whole", "patient"}) {
    Viewing finished({work.at(run)});
    EXPECT_EQ(finished.end(SIGINT).err, "view: Ctrl-C ends the view\n") << run;
  }
}

TEST_F(CliView, OtherMachines) {
  ::setenv("SSH_CONNECTION", "192.0.2.1 50000 192.0.2.7 22", 1);
  Viewing local({work.at("site"), "--allow-host", "proxy.example"});
  EXPECT_TRUE(local.get("/", "proxy.example").starts_with("HTTP/1.1 200 "));
  const std::string port = std::to_string(local.port), tunnel = local.end(SIGINT).err;
  EXPECT_NE(tunnel.find("ssh -L " + port + ":127.0.0.1:" + port + " "), std::string::npos)
      << tunnel;
  EXPECT_NE(tunnel.find("192.0.2.7`"), std::string::npos) << tunnel;
  Viewing open({work.at("site"), "--host", "0.0.0.0"});
  EXPECT_NE(open.end(SIGINT).err.find("plain HTTP"), std::string::npos);
}

// Bug put back: the address as the argument of xdg-open, where all users of the machine see it;
// seen to fail.
TEST_F(CliView, TheBrowserGetsTheTokenInAPrivateFile) {
  work.write("programs/xdg-open",
             "#!/bin/sh\n"
             "cp \"$1\" \"" +
                 work.at("copied") +
                 "\"\n"
                 "stat -c '%a' \"$1\" \"$(dirname \"$1\")\" >\"" +
                 work.at("modes") +
                 "\"\n"
                 "echo \"$*\" >\"" +
                 work.at("part") +
                 "\"\n"
                 "mv \"" +
                 work.at("part") + "\" \"" + work.at("words") + "\"\n");
  fs::permissions(work / "programs/xdg-open", fs::perms::owner_all);
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", (work.at("programs") + ":" + path).c_str(), 1);
  ::setenv("DISPLAY", ":99", 1);
  Viewing viewing({work.at("site")});
  for (int i = 0; i < 100 && !fs::exists(work / "words"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const std::string address = viewing.end(SIGTERM).out;
  ::setenv("PATH", path.c_str(), 1);
  ::unsetenv("DISPLAY");
  std::string words = work.read("words");
  words.pop_back();
  EXPECT_EQ(words.find("token"), std::string::npos) << words;
  EXPECT_TRUE(words.starts_with(work.at("temporary"))) << words;
  EXPECT_NE(work.read("copied").find("url=" + address.substr(0, address.size() - 1) + "\""),
            std::string::npos)
      << address;
  EXPECT_EQ(work.read("modes"), "600\n700\n");
  EXPECT_FALSE(fs::exists(words)) << "removed at the end";
}

/// The JSON of an address.
json json_of(const Viewing& viewing, const std::string& path) {
  const std::string answer = viewing.get(path);
  return json::parse(answer.substr(answer.find("\r\n\r\n")));
}

// kill -9 of either side hurts neither. Bug put back: a lock that is free counts as a training;
// seen to fail.
TEST_F(CliView, ATrainingThatIsKilledAndAViewThatIsKilled) {
#if !TESSERA_HAS_PLAYER
  GTEST_SKIP() << "built without the player";
#endif
  const ScratchFolder scratch;
  ChildProcess training(work.train_arguments("run", {"--iterations", "1000000"}), scratch.path());
  ASSERT_TRUE(training.wait_until([&] { return fs::exists(work / "run/config.json"); }));
  {
    Viewing killed({work.at("run"), "--json"});
    EXPECT_EQ(json_of(killed, "/api/run")["kind"], "training");
    EXPECT_TRUE(json_of(killed, "/api/state")["alive"]);
    killed.end(SIGKILL);
  }
  Viewing viewing({work.at("run"), "--json"});
  ASSERT_TRUE(training.wait_until([&] {
    const json state = json_of(viewing, "/api/state");
    return state["alive"] && !state["state"].is_null() && state["state"]["snapshot"] > 0;
  })) << "the training still runs, and shows itself";
  training.send(SIGKILL);
  training.wait();
  const auto alive = [&] { return json_of(viewing, "/api/state")["alive"].get<bool>(); };
  for (int i = 0; i < 100 && alive(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_FALSE(alive());
  EXPECT_TRUE(viewing.get("/live").starts_with("HTTP/1.1 200 "));
  viewing.end(SIGTERM);
  EXPECT_FALSE(fs::exists(work / "run/live")) << "what the killed training has left";
}

TEST_F(CliView, WhatCannotBeIsRefused) {
  const Viewing viewing({work.at("site")});
  work.write("text.ply", "no splats");
  const std::vector<std::pair<std::vector<std::string>, std::vector<std::string>>> rows = {
      {{work.at("nowhere")}, {"nowhere", "no such file", "expected"}},
      {{work.at("capture")}, {"capture: is a scene, no model"}},
      {{work.at("text.ply")}, {"text.ply"}},
      {{work.at("site"), "--port", "65536"}, {"--port", "65536"}},
      {{work.at("site"), "--port", std::to_string(viewing.port)}, {"--port", "--port 0"}},
      {{work.at("site"), "--host", "no host"}, {"--host", "127.0.0.1"}},
  };
  for (std::vector<std::string> arguments; const auto& [more, parts] : rows) {
    arguments = {"view"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    work.expect_refused(arguments, parts);
  }
}

}  // namespace
}  // namespace tessera::testing
