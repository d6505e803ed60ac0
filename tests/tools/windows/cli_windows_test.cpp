// A long clip that is trained window by window: `train --windows`, `evaluate`, `export` and `run`
// of the whole, limits, failures, and what is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/files/png.h"
#include "recon4d/model/model_file.h"
#include "static3d/tessera4d/windowed_file.h"
#include "tests/support/set_values.h"
#include "tests/tools/windows/cli_windows_fixture.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The images of the whole clip in OUT are those that each window has of itself.
void expect_views_of_windows(const CliWorkspace& work, const json& whole) {
  const auto images_of = [](const json& run) {
    std::map<std::string, std::pair<json, json>> images;
    for (const json& view : run["views"])
      if (view["strip"] == true) images[view["name"]] = {view["truth"], view["result"]};
    return images;
  };
  const auto all = images_of(whole);
  for (const char* window : {"0000", "0001"}) {
    const json report = work.run_json({"report", work.at(std::string("out/run/windows/") + window),
                                       "--backend", "cpu", "-o", work.at("of_window")});
    int found = 0;
    for (const auto& [name, images] : images_of(report["runs"][0]))
      if (const auto same = all.find(name); same != all.end()) {
        EXPECT_EQ(same->second, images) << name;
        ++found;
      }
    EXPECT_GE(found, 3) << window;
  }
}

// Bugs put back, each seen to fail: each window trains static Gaussians of its own; scores of the
// timesteps beyond the core; checkpoints that stay; times of a window in the place of those of the
// clip. Finds also: a window that sees other timesteps than its core and eight beyond; a file of
// windows without one of them. Also: pixels that move by the frames of a window alone.
TEST_F(CliWindows, AreTrainedScoredAndExportedAsOneClip) {
  const json trained = work.run_json(train("run"));
  EXPECT_TRUE(trained["finished"]);
  EXPECT_EQ(trained["windows"], 2);
  const json plan = json::parse(work.read("run/windows.json"));
  EXPECT_NEAR(double(plan["windows"][0]["drawn"][1]), 23.5 / 47, 1e-6) << "midway of 23 and 24";
  EXPECT_NEAR(double(plan["windows"][1]["time"][0]), 16.0 / 47, 1e-6);
  const GaussianModel shared = load_model(work / "run/static/model.ply");
  ASSERT_GT(shared.static_set.count(), 20);
  EXPECT_EQ(shared.dynamic_set.count(), 0);
  int64_t dynamic = 0;
  for (const char* window : {"0000", "0001"}) {
    const std::string run = std::string("run/windows/") + window;
    const GaussianModel model = load_model(work / (run + "/model.ply"));
    EXPECT_EQ(values_of(model.static_set), values_of(shared.static_set)) << window;
    EXPECT_GT(model.dynamic_set.count(), 0);
    dynamic += model.dynamic_set.count();
    EXPECT_FALSE(fs::exists(work / (run + "/checkpoint.ckpt")));
    EXPECT_EQ(json::parse(work.read(run + "/config.json"))["train_frames"], 3 * 32);
  }
  EXPECT_EQ(trained["num_dynamic"], dynamic);

  const json scores = work.run_json({"evaluate", work.at("run"), "--backend", "cpu"});
  EXPECT_EQ(scores["windows"], 2);
  EXPECT_EQ(scores["num_static"], shared.static_set.count());
  EXPECT_EQ(scores["num_dynamic"], dynamic);
  std::set<int64_t> times;
  for (const json& view : scores["per_view"]) times.insert(std::lround(47 * double(view["time"])));
  EXPECT_EQ(scores["per_view"].size(), 48u);
  EXPECT_EQ(times.size(), 48u);
  EXPECT_EQ(*times.rbegin(), 47);
  EXPECT_TRUE(scores["borders"]["border"].is_number());
  EXPECT_TRUE(scores["borders"]["inside"].is_number());

  // where nothing is known to stand still in the clip, all pixels move
  for (const auto& entry : fs::recursive_directory_iterator(work / "run/static_scene/masks"))
    if (entry.is_regular_file()) {
      Image8 mask = read_png(entry.path());
      std::fill(mask.data.begin(), mask.data.end(), uint8_t{0});
      write_png(entry.path(), mask);
    }
  const json moving = work.run_json({"evaluate", work.at("run"), "--backend", "cpu"});
  EXPECT_NEAR(double(moving["psnr_dynamic"]), double(moving["psnr"]), 0.02);
  EXPECT_LT(std::abs(double(scores["psnr"]) - double(moving["psnr"])), 1e-6);
  EXPECT_GT(std::abs(double(scores["psnr_dynamic"]) - double(moving["psnr_dynamic"])), 0.05);

  const json exported =
      work.run_json({"export", work.at("run"), "-o", work.at("4d"), "--format", "tessera"});
  EXPECT_EQ(exported["windows"], 2);
  Tessera4dParts parts = open_tessera4d(work / "4d");
  ASSERT_EQ(parts.windows().size(), 2u);
  EXPECT_EQ(parts.load(1).static_set.count(), shared.static_set.count());
  EXPECT_EQ(
      work.run({"export", work.at("run"), "-o", work.at("one"), "--format", "tessera", "--single"})
          .exit_code,
      0);
  EXPECT_EQ(open_tessera4d(work / "one/scene.t4d").manifest().blocks.size(),
            parts.manifest().blocks.size());
  work.expect_refused({"export", work.at("run"), "-o", work.at("model"), "--format", "model"},
                      {"2 windows", "--format model", "windows/0000"});
}

// A clip whose light goes down by 30 % where its second window begins. Bugs put back, each seen to
// fail: a static set that stays in the light of the background; a file without the light.
TEST_F(CliWindows, OneThatIsDarkerHasTheStaticSetInItsLight) {
  ASSERT_EQ(work.run({"synth", "room", "-o", work.at("dim"), "--layout", "n3dv", "--cameras", "4",
                      "--frames", "48", "--width", "64", "--height", "48", "--supersampling", "1",
                      "--light-step", "0.7"})
                .exit_code,
            0);
  ASSERT_EQ(work.run({"ingest", work.at("dim"), "-o", work.at("scene"), "--cloud", "none",
                      "--frames-as", "video", "--overwrite"})
                .exit_code,
            0);
  work.run_json(train("run"));
  const auto config = [&](const char* window) {
    return json::parse(work.read(std::string("run/windows/") + window + "/config.json"));
  };
  EXPECT_FALSE(config("0000").contains("light"));
  const LightGain light = config("0001").at("light");
  for (const double factor : light) EXPECT_NEAR(factor, 0.7, 0.1);
  GaussianModel shared = load_model(work / "run/static/model.ply");
  apply_light(light, shared.static_set);
  EXPECT_EQ(values_of(load_model(work / "run/windows/0001/model.ply").static_set),
            values_of(shared.static_set));
  work.run_json(
      {"export", work.at("run"), "-o", work.at("4d"), "--format", "tessera", "--lossless"});
  Tessera4dParts parts = open_tessera4d(work / "4d");
  EXPECT_EQ(parts.windows()[0].light, kSameLight);
  EXPECT_EQ(parts.windows()[1].light, light);
}

// Bugs put back, each seen to fail: every view and frame by the first window; at the time of the
// clip in the place of the window's; a batch of views that reaches into the next window.
TEST_F(CliWindows, ViewsAndFramesAreThoseOfTheirWindow) {
  ASSERT_EQ(work.run({"ingest", work.at("room"), "-o", work.at("scene"), "--cloud", "none",
                      "--frames-as", "video", "--frames", "46", "--overwrite"})
                .exit_code,
            0);
  ASSERT_EQ(work.run_json(train("run"))["windows"], 2) << "of 23 timesteps";
  const json windows = json::parse(work.read("run/windows.json"))["windows"];
  /// The run of the window that is drawn at t, and what t is in it.
  const auto window_of = [&](double t) {
    for (const json& window : windows)
      if (t < window["drawn"][1] || window["drawn"][1] == 1) {
        const double low = window["time"][0], high = window["time"][1];
        return std::pair("run/" + window["folder"].get<std::string>(), (t - low) / (high - low));
      }
    throw std::out_of_range("no window");
  };
  const auto render = [&](const std::string& model, const std::string& out) {
    return work.run_json({"render", work.at(model), "--cameras", work.at("scene"), "--split",
                          "test", "-o", work.at(out), "--backend", "cpu"});
  };
  const json all = render("run", "all");
  EXPECT_EQ(all["windows"], 2);
  ASSERT_EQ(all["count"], 46);
  for (const json& window : windows)
    render("run/" + window["folder"].get<std::string>(),
           "of/run/" + window["folder"].get<std::string>());
  for (const json& frame : all["frames"]) {
    const std::string file = "/" + frame["file"].get<std::string>();
    EXPECT_EQ(work.read("all" + file), work.read("of/" + window_of(frame["time"]).first + file));
  }
  EXPECT_NE(work.read("of/run/windows/0000/cam00/00030.png"), work.read("all/cam00/00030.png"));
  const auto frames = [&](const std::string& model, const std::string& out,
                          const std::vector<std::string>& times) {
    std::vector<std::string> command{"export",     work.at(model), "-o",
                                     work.at(out), "--format",     "ply"};
    command.insert(command.end(), times.begin(), times.end());
    return work.run_json(command);
  };
  EXPECT_EQ(frames("run", "ply", {"--frames", "5"})["windows"], 2);
  const json manifest = json::parse(work.read("ply/manifest.json"));
  ASSERT_EQ(manifest["count"], 5);
  EXPECT_EQ(manifest["time_axis"]["duration"],
            json::parse(work.read("run/windows.json"))["time"]["duration"]);
  for (const json& frame : manifest["frames"]) {
    const auto [run, time] = window_of(frame["time"]);
    frames(run, "one", {"--time", json(time).dump(), "--overwrite"});
    EXPECT_EQ(work.read("ply/" + frame["file"].get<std::string>()),
              work.read("one/frame_0000.ply"));
  }
  EXPECT_EQ(frames("run", "all_frames", {})["frames"], 46) << "at the rate of the cameras";
  const ChildResult warned =
      work.run({"export", work.at("run"), "-o", work.at("splats"), "--format", "splat"});
  EXPECT_NE(warned.err.find("antialiased (mip)"), std::string::npos) << "as of one model";
  const ChildResult path = work.run({"render", work.at("run"), "--path", "spiral", "--fps", "12",
                                     "--seconds", "2", "-o", work.at("path"), "--backend", "cpu"});
  EXPECT_EQ(path.exit_code, 0) << path.err;
  EXPECT_TRUE(fs::exists(work / "path/frame_0023.png"));
}

// Bugs put back, each seen to fail: a second command trains all again; checkpoints that stay;
// `auto` decided anew, as by the memory of another machine. Finds also: another request that
// replaces what is there; another cut in the same folder; what is of one training taken in silence.
TEST_F(CliWindows, GoOnWhereTheyWereAndLoseNothing) {
  const ChildResult stopped = work.run(train("run", {"--time-limit", "0.001s"}));
  EXPECT_NE(stopped.exit_code, 0);
  work.run_json(train("run"));
  const WrittenFiles before = work.written("run", "model.ply");
  ASSERT_EQ(before.size(), 3u);
  EXPECT_TRUE(work.run_json(train("run"))["finished"]);
  EXPECT_EQ(work.written("run", "model.ply"), before) << "nothing is trained again";
  work.expect_refused(train("run", {"--lr-opacity", "0.04"}),
                      {"holds a finished run", "lr_opacity"});
  std::vector<std::string> longer = train("run");
  longer[5] = "0.7s";
  work.expect_refused(longer, {"windows 2 → 3", "take another -o"});
  EXPECT_EQ(work.written("run", "model.ply"), before);
  work.expect_refused(train("new", {"--window", "1/2"}), {"--windows", "--window is of one"});
  longer[5] = "0.1s";
  work.expect_refused(longer, {"20 windows", "less than 12"});
  longer[5] = "auto";  // of two seconds it would make none
  EXPECT_EQ(work.run_json(longer)["windows"], 2) << "as it is there";
  EXPECT_EQ(work.written("run", "model.ply"), before);
  longer[5] = "1s";
  longer.emplace_back("--static");
  work.expect_refused(longer, {"--windows 1s", "--static", "leave one of them out"});
  longer.pop_back();
  longer[5] = "soon";
  work.expect_refused(longer, {"--windows soon", "5s"});

  // a window that is lost is trained again, and comes out the same
  const std::string lost = work.read("run/windows/0001/model.ply");
  fs::remove_all(work / "run/windows/0001");
  work.expect_refused({"evaluate", work.at("run")}, {"1 of 2 windows", "window 2"});
  work.run_json(train("run"));
  EXPECT_EQ(work.read("run/windows/0001/model.ply"), lost);
}

// Finds: a stage of `run` that looks for one model; a second run that trains again. Bugs put back,
// each seen to fail: views of all windows by the model of the first; a report without all windows
// is an error.
TEST_F(CliWindows, ComeOutOfRunAsOneResult) {
  const auto run = [&](const std::vector<std::string>& more, const char* windows = "1s") {
    std::vector<std::string> command{"run", work.at("room"), "-o", work.at("out")};
    command.insert(command.end(), {"--windows", windows, "--cloud", "none"});
    return tiny(command, more);
  };
  const json result = work.run_json(run({"--iterations", "12", "--export-frames", "5"}));
  EXPECT_EQ(result["windows"], 2);
  EXPECT_EQ(result["export"]["frames"], 5);
  EXPECT_EQ(json::parse(work.read("out/frames/manifest.json"))["count"], 5);
  EXPECT_EQ(result["training"]["windows"], 2);
  EXPECT_EQ(json::parse(work.read("out/run/metrics.json"))["per_view"].size(), 48u);
  if (TESSERA_HAS_PLAYER) {
    EXPECT_EQ(open_tessera4d(work / "out/player").windows().size(), 2u);
    EXPECT_TRUE(fs::exists(work / "out/report/index.html"));
  }
  const json report = json::parse(work.read("out/report/report.json"));
  EXPECT_EQ(report["kind"], "run");
  ASSERT_EQ(report["runs"].size(), 1u);
  EXPECT_EQ(report["runs"][0]["windows"].size(), 2u);
  EXPECT_EQ(report["runs"][0]["scores"]["psnr"], result["psnr"]);
  EXPECT_GT(report["runs"][0]["seconds"]["command"], 0);
  expect_views_of_windows(work, report["runs"][0]);
  const WrittenFiles before = work.written("out", "model.ply");
  ASSERT_EQ(before.size(), 3u);
  work.run_json(run({"--iterations", "12", "--export-frames", "5"}));
  EXPECT_EQ(work.written("out", "model.ply"), before);
  work.expect_refused(run({"--iterations", "14"}), {"holds a finished run", "iterations 12 → 14"});
  EXPECT_EQ(work.written("out", "model.ply"), before);
  work.run_json(run({"--iterations", "14", "--overwrite"}));
  EXPECT_EQ(work.written("out", "model.ply").size(), 3u);
  EXPECT_NE(work.written("out", "model.ply"), before);
  EXPECT_EQ(work.written("out.1", "model.ply").size(), 3u);
  EXPECT_EQ(json::parse(work.read("out/run/windows.json"))["scene"],
            fs::absolute(work / "out/scene").string());
  EXPECT_EQ(work.run_json({"evaluate", work.at("out"), "--backend", "cpu"})["windows"], 2);

  fs::rename(work / "out/run/windows/0001/model.ply", work / "model.ply");
  json again = work.run_json({"report", work.at("out"), "--backend", "cpu"})["runs"][0];
  EXPECT_NE(again["image_note"].get<std::string>().find("1 of 2 windows are not trained"),
            std::string::npos);
  EXPECT_EQ(again["windows"].size(), 2u);
  work.write("out/run/windows/0001/model.ply", "damaged");
  again = work.run_json({"report", work.at("out"), "--backend", "cpu"})["runs"][0];
  EXPECT_NE(again["image_note"].get<std::string>().find("windows/0001/model.ply"),
            std::string::npos);
  EXPECT_EQ(again["scores"]["psnr"], json::parse(work.read("out/run/metrics.json"))["psnr"]);
  fs::rename(work / "model.ply", work / "out/run/windows/0001/model.ply");
  fs::remove(work / "out/run/metrics.json");
  again = work.run_json({"report", work.at("out"), "--backend", "cpu"})["runs"][0];
  EXPECT_GT(again["scores"]["psnr"], 5) << "is scored for it";
}

// Bug put back: a capture of numbered frames is cut by seconds, and its background is refused; seen
// to fail.
TEST_F(CliWindows, AreNotCutOfFramesWithoutSeconds) {
  ASSERT_EQ(
      work.run({"ingest", work.at("room"), "-o", work.at("frames"), "--cloud", "none"}).exit_code,
      0);
  work.edit_json("frames/transforms.json", [](json& file) {
    file.erase("tessera");
    for (json& frame : file["frames"]) {
      frame["time"] = 47 * double(frame["time"]);
      frame["camera"] = frame["tessera"]["camera"];
      frame.erase("tessera");
    }
  });
  const ChildResult made =
      work.run(tiny({"run", work.at("frames"), "-o", work.at("out")}, {"--iterations", "4"}));
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_NE(made.err.find("trained as a whole"), std::string::npos) << made.err;
  work.expect_refused(tiny({"train", work.at("frames"), "-o", work.at("w"), "--windows", "12s"},
                           {"--iterations", "4"}),
                      {"--windows 12s", "not prepared"});
}

// Finds: a second program trains beside the first; one begins what the child of a killed one still
// has in work; other bytes by another course of events.
TEST_F(CliWindows, AreTrainedByOneProgramAndOutliveAKilledOne) {
  work.run_json(train("run"));
  std::map<std::string, std::string> models;
  for (const auto& [file, time] : work.written("run", "model.ply"))
    models[fs::relative(file, work / "run").string()] = work.read(fs::relative(file, work.path()));
  const std::vector<std::string> words = train("killed", {"--iterations", "60"});
  fs::create_directory(work / "other");
  ChildProcess killed(words, work / "other");
  ASSERT_TRUE(
      killed.wait_until([&] { return fs::exists(work / "killed/windows/0000/config.json"); }));
  work.expect_refused(words, {"killed"});
  killed.send(SIGKILL);
  EXPECT_EQ(killed.wait().signal, SIGKILL);
  EXPECT_TRUE(work.run_json(words)["finished"]);
  work.run_json(train("long", {"--iterations", "60"}));
  for (const auto& [file, bytes] : models)
    EXPECT_TRUE(work.read("killed/" + file) == work.read("long/" + file)) << file;
  const std::string log = work.read("killed/logs/window-1.log");
  EXPECT_EQ(log.find("starts anew"), std::string::npos) << log;
}

// Finds: the static set takes the whole limit, so that nothing moves; each window takes it.
TEST_F(CliWindows, LimitsOfSizeAreThoseOfTheClip) {
  const json few = work.run_json(train("few", {"--max-gaussians", "120", "--iterations", "40"}));
  EXPECT_LE(few["num_static"], 60);
  EXPECT_LE(few["num_gaussians"], 120);
  for (const json& window : few["parts"]) EXPECT_GT(window["num_dynamic"], 5);
  const json small = work.run_json(train("small", {"--max-bytes", "30kB", "--iterations", "40"}));
  for (const json& window : small["parts"]) EXPECT_GT(window["num_dynamic"], 5);
  work.run_json(
      {"export", work.at("small"), "-o", work.at("one"), "--format", "tessera", "--single"});
  EXPECT_LE(fs::file_size(work / "one/scene.t4d"), 30000u);
  EXPECT_GT(fs::file_size(work / "one/scene.t4d"), 15000u);
}

// Finds: exit code 2; the next window is begun; a limit that leaves no room for a step is left for
// ever.
TEST_F(CliWindows, ATimeLimitIsThatOfAllOfThem) {
  const auto begin = std::chrono::steady_clock::now();
  const ChildResult left = work.run(train("run", {"--time-limit", "4s", "--iterations", "3000"}));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_EQ(left.exit_code, 75) << left.err;
  EXPECT_LT(took.count(), 9);
  EXPECT_TRUE(fs::exists(work / "run/static/checkpoint.ckpt"));
  EXPECT_FALSE(fs::exists(work / "run/windows"));
  const ChildResult none = work.run(train("none", {"--time-limit", "0.01s"}));
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.err.find("--time-limit: 0.01 s leave room for no step"), std::string::npos)
      << none.err;
}

// Finds: a window that cannot be trained ends the work; what it said is lost.
TEST_F(CliWindows, OneThatFailsCostsNoOther) {
  work.write("run/windows/0000/model.ply", "a file of somebody else");
  const ChildResult failed = work.run(train("run"));
  EXPECT_EQ(failed.exit_code, 2) << failed.err;
  EXPECT_NE(failed.err.find("1 of 2 windows are not trained. window 1 of 2: "), std::string::npos)
      << failed.err;
  EXPECT_TRUE(fs::exists(work / "run/windows/0001/model.ply"));
  fs::remove(work / "run/windows/0000/model.ply");
  EXPECT_TRUE(work.run_json(train("run"))["finished"]);
}

// Bug put back: a static set of what moves is taken; seen to fail. Finds also: one of another
// scene; options that change static Gaussians; a resumed training that forgets the static set.
TEST_F(CliWindows, ShareAStaticModelOfTheSameWorldAlone) {
  work.run_json(train("run"));
  const auto window = [&](const std::string& shared, const std::vector<std::string>& more) {
    std::vector<std::string> command{"train", work.at("scene"), "-o", work.at("w")};
    command.insert(command.end(), {"--window", "1/2", "--iterations", "12", "--static-model"});
    command.push_back(work.at(shared));
    return tiny(command, more);
  };
  work.expect_refused(window("run/windows/0000", {}), {"not what stands still", "unpack --static"});
  work.expect_refused(window("scene", {}), {"no finished training", "unpack --static"});
  work.expect_refused(window("run/static", {"--filter-3d", "mip"}), {"--static-model"});
  work.expect_refused(window("run/static", {"--train-scale", "0.5"}), {"--train-scale 1"});
  EXPECT_EQ(work.run(window("run/static", {"--stop-after", "4"})).exit_code, 0);
  EXPECT_EQ(
      work.run({"train", work.at("scene"), "-o", work.at("w"), "--resume", "--backend", "cpu"})
          .exit_code,
      0);
  const json resumed = json::parse(work.read("w/config.json"));
  EXPECT_EQ(resumed["static_model"]["run"], fs::absolute(work / "run/static").string());
  EXPECT_EQ(values_of(load_model(work / "w/model.ply").static_set),
            values_of(load_model(work / "run/static/model.ply").static_set));
}

}  // namespace
}  // namespace tessera::testing
