// The plan is written once, before anything is trained.
#include "tools/session/windows_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"
#include "tools/session/run_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kVersion = 1;

/// The first and last time at which a frame of a timestep was taken.
struct TimesOfStep {
  double first = std::numeric_limits<double>::infinity();
  double last = -std::numeric_limits<double>::infinity();
};

std::vector<TimesOfStep> times_of_steps(const Scene& scene) {
  std::vector<TimesOfStep> steps;
  for (const Frame& frame : scene.frames) {
    if (frame.timestep >= int64_t(steps.size())) steps.resize(size_t(frame.timestep) + 1);
    TimesOfStep& step = steps[size_t(frame.timestep)];
    step.first = std::min(step.first, frame.time);
    step.last = std::max(step.last, frame.time);
  }
  return steps;
}

Interval interval_of(const json& list) {
  return {list.at(0).get<double>(), list.at(1).get<double>()};
}

}  // namespace

std::vector<FileWindow> cut_clip(const Scene& scene, int64_t count, int64_t overlap) {
  const std::vector<TimesOfStep> steps = times_of_steps(scene);
  std::vector<FileWindow> windows;
  for (int64_t i = 0; i < count; ++i) {
    const TimestepRange trained = range_of({i, count, overlap}, int64_t(steps.size())),
                        core = range_of({i, count, 0}, int64_t(steps.size()));
    FileWindow window;
    for (int64_t k = trained.first; k <= trained.last; ++k) {
      window.time.low = k == trained.first ? steps[size_t(k)].first
                                           : std::min(window.time.low, steps[size_t(k)].first);
      window.time.high = k == trained.first ? steps[size_t(k)].last
                                            : std::max(window.time.high, steps[size_t(k)].last);
    }
    window.drawn.low = i == 0 ? 0 : windows.back().drawn.high;
    window.drawn.high =
        i + 1 == count ? 1
                       : (steps[size_t(core.last)].last + steps[size_t(core.last) + 1].first) / 2;
    windows.push_back(window);
  }
  if (const std::string wrong = wrong_windows(windows); !wrong.empty())
    throw InputError(fmt::format("{}: cannot be cut into {} windows: {}; its times are in disorder",
                                 scene.path, count, wrong));
  return windows;
}

fs::path WindowsFolder::window_run(int64_t index) const {
  return root / "windows" / fmt::format("{:04}", index);
}

WindowsPlan WindowsFolder::read() const {
  const json file = read_json(plan_file());
  try {
    if (file.at("format") != "tessera-windows") throw InputError("");
    if (file.at("version").get<int>() > kVersion)
      throw InputError(fmt::format("{}: is of version {}, this program knows {}; use the newer one",
                                   plan_file().string(), file["version"].dump(), kVersion));
    WindowsPlan plan{file.at("scene").get<std::string>(),
                     file.at("overlap").get<int64_t>(),
                     {},
                     {},
                     file.value("request", json())};
    plan.clip = {file.at("time").at("origin").get<double>(),
                 file.at("time").at("duration").get<double>()};
    for (const json& window : file.at("windows"))
      plan.windows.push_back({interval_of(window.at("time")), interval_of(window.at("drawn"))});
    if (const std::string wrong = wrong_windows(plan.windows); !wrong.empty())
      throw InputError(fmt::format("{}: {}", plan_file().string(), wrong));
    return plan;
  } catch (const json::exception&) {
    throw InputError(fmt::format(
        "{}: is damaged; remove it and repeat the command, which leaves the trained windows as "
        "they are",
        plan_file().string()));
  }
}

void WindowsFolder::write(const WindowsPlan& plan) const {
  make_folder(root);
  json file = {{"format", "tessera-windows"},
               {"version", kVersion},
               {"scene", plan.scene},
               {"request", plan.request},
               {"overlap", plan.overlap},
               {"time", {{"origin", plan.clip.origin}, {"duration", plan.clip.duration}}},
               {"static", "static"},
               {"windows", json::array()}};
  for (size_t i = 0; i < plan.windows.size(); ++i) {
    json window = to_json(plan.windows[i]);
    window["folder"] = window_run(int64_t(i)).lexically_relative(root).string();
    file["windows"].push_back(std::move(window));
  }
  write_text_file(plan_file(), json_text(file, 1) + "\n");
}

bool WindowsFolder::is_finished(const fs::path& run) {
  const RunFolder folder{run};
  return fs::exists(folder.model()) && !fs::exists(folder.checkpoint());
}

std::vector<int64_t> WindowsFolder::missing(const WindowsPlan& plan) const {
  std::vector<int64_t> missing;
  for (int64_t i = 0; i < int64_t(plan.windows.size()); ++i)
    if (!is_finished(window_run(i))) missing.push_back(i + 1);
  return missing;
}

void require_all_windows(const WindowsFolder& folder, const WindowsPlan& plan) {
  const std::vector<int64_t> missing = folder.missing(plan);
  if (missing.empty()) return;
  throw InputError(fmt::format(
      "{}: {} of {} windows are not trained yet, the first of them is window {}; repeat the "
      "command that trains them",
      folder.root.string(), missing.size(), plan.windows.size(), missing.front()));
}

WindowsFolder windows_folder_of(const fs::path& path) {
  const WindowsFolder inside{path / "run"};
  return inside.exists() ? inside : WindowsFolder{path};
}

}  // namespace tessera
