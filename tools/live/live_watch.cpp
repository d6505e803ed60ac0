// Reads the files of a training, and scores its snapshots on a thread.
#include "tools/live/live_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "ingest/files/png.h"
#include "ingest/prepared/scene_reader.h"
#include "kernels/base/parallel.h"
#include "recon4d/evaluation/metrics.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/options/train_options_json.h"
#include "static3d/tessera4d/player_hints.h"
#include "static3d/tessera4d/windowed_file.h"
#include "tools/cli/background_program.h"
#include "tools/live/live_folder.h"
#include "tools/live/stopped_training.h"
#include "tools/report/log_events.h"
#include "tools/report/run_report.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr auto kAskEvery = std::chrono::milliseconds(500);
constexpr auto kAliveFor = std::chrono::seconds(5);  // after the last change of its counter
constexpr int64_t kViews = 4;
constexpr double kShareOfScores = 0.01;  // of the cores
constexpr int kNiceOfScores = 19;

/// An address of the server; "" where the path is not in what it serves, or is being removed.
std::string address_of(const fs::path& path, const fs::path& served) {
  std::error_code removed;
  const fs::path inside =
      fs::weakly_canonical(path, removed).lexically_relative(fs::weakly_canonical(served, removed));
  if (inside.empty() || *inside.begin() == "..") return "";
  return "/" + inside.generic_string();
}

}  // namespace

LiveWatch::LiveWatch(const fs::path& run, const fs::path& served, std::string resumed_by)
    : run_{run},
      folder_(run),
      served_(served),
      name_(fs::weakly_canonical(served).filename().string()),
      truths_("live"),
      resumed_by_(std::move(resumed_by)) {
  thread_ = std::thread([this] {
    lower_priority(kNiceOfScores);
    const SerialSection serial;
    try {
      score_snapshots();
    } catch (const std::exception&) {  // the model is shown without scores
    }
  });
}

LiveWatch::~LiveWatch() {
  {
    const std::lock_guard held(mutex_);
    leaves_ = true;
  }
  wake_.notify_all();
  thread_.join();
  if (!is_run_locked(run_.root)) folder_.remove();
}

void LiveWatch::ask(int64_t seen) {
  if (Clock::now() - asked_ < kAskEvery) return;
  asked_ = Clock::now();
  ++request_.counter;
  request_.seen = seen;
  std::error_code absent;
  try {
    if (!fs::exists(folder_.root(), absent) && is_run_locked(run_.root)) folder_.make();
    if (fs::exists(folder_.root(), absent)) folder_.write(request_);
  } catch (const fs::filesystem_error&) {  // a folder of another user: no request can be written
  }
}

std::string LiveWatch::state(int64_t seen) {
  const std::lock_guard held(mutex_);
  ask(seen);
  const std::optional<LiveState> now = folder_.state();
  if (now && (!last_ || now->counter != last_->counter || now->training != last_->training)) {
    last_ = now;
    counted_ = Clock::now();
  }
  const bool alive = is_alive(now.has_value());
  const std::optional<LiveState>& state = last_;
  json result = {{"alive", alive}, {"state", nullptr}, {"snapshot", ""}, {"resume", ""}};
  result["name"] = name_;
  if (state) {
    result["state"] = json::parse(text_of(*state));
    if (now && state->snapshot > 0)
      result["snapshot"] = address_of(folder_.snapshot(state->snapshot), served_);
  }
  const auto stopped = alive ? std::nullopt : stopped_training(run_);
  const bool complete = !alive && is_complete(run_);
  result["complete"] = complete;
  result["page"] = complete && has_player_of(run_, served_) ? "/player/" : "";
  result["stopped"] = stopped ? json{{"step", stopped->step}, {"total", stopped->total}} : json();
  owes_resume_ = owes_resume_ && !stopped;
  if (stopped)
    result["resume"] = resumed_by_.empty() ? shell_line(resume_words(run_)) : resumed_by_;
  result["views"] = json::array();
  for (size_t i = 0; i < views_.size(); ++i)
    result["views"].push_back(truth_json(scene_.frames[i], fmt::format("/api/truth?view={}", i)));
  result["scores"] = scores_;
  return json_text(result);
}

std::string LiveWatch::report() {
  const std::lock_guard held(mutex_);
  std::error_code absent;
  const std::pair now{fs::file_size(run_.log(), absent), scores_.size()};
  if (absent || now == reported_) return report_;
  json report;
  try {
    report = run_report({run_.read_config(), {}, {}, read_text_file(run_.log())});
  } catch (const std::exception&) {  // the run is removed or replaced meanwhile
    return report_;
  }
  json& curve = report["curves"]["psnr_test"] = to_json(std::vector<CurvePoint>());
  for (const auto& [step, psnr] : scores_) {
    curve["step"].push_back(step);
    curve["seconds"].push_back(nullptr);
    curve["value"].push_back(psnr);
  }
  report_ = json_text(report);
  reported_ = now;
  return report_;
}

std::string LiveWatch::truth(int64_t view) const {
  const std::lock_guard held(mutex_);
  return view >= 0 && size_t(view) < views_.size() ? views_[size_t(view)] : "";
}

bool LiveWatch::owes_resume() {
  const std::lock_guard held(mutex_);
  return owes_resume_;
}

bool LiveWatch::stop() {
  const std::lock_guard held(mutex_);
  const std::optional<LiveState> state = folder_.state();
  if (!state || Clock::now() - counted_ >= kAliveFor) return false;
  request_.stop_training = state->training;
  owes_resume_ = true;
  ++request_.counter;
  return folder_.write(request_);
}

/// What was written by one that was killed, or is removed in the end, is no sign of life.
bool LiveWatch::is_alive(bool has_state) const {
  return (last_ && has_state && Clock::now() - counted_ < kAliveFor) || is_run_locked(run_.root);
}

/// Once the training shows something: its config.json is there then.
void LiveWatch::load_views() {
  const TrainOptions options = train_options_from_json(run_.read_config().at("options"));
  SceneOptions wanted;
  wanted.background = parse_background(options.background);
  wanted.allow_static = true;
  wanted.held_out = kViews;
  wanted.window = run_.window();
  Scene scene = load_scene(run_.scene(), wanted);
  std::vector<std::string> views;
  for (const Frame& frame : scene.frames) {
    const fs::path file = truths_.path() / "truth.png";
    write_png(file, frame.image);
    views.push_back(read_text_file(file));
  }
  const std::lock_guard held(mutex_);
  scene_ = std::move(scene);
  views_ = std::move(views);
}

double LiveWatch::score(const fs::path& file) const {
  const GaussianModel model = open_tessera4d(file).load(0);
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  double sum = 0;
  for (const Frame& frame : scene_.frames) {
    const RenderedImage image = render_views(*backend, model, {{frame.camera, frame.time}}).at(0);
    sum += psnr_float({image.rgb.data(), int64_t(image.rgb.size())}, frame.image, used_mask(frame));
  }
  return sum / double(scene_.frames.size());
}

void LiveWatch::score_snapshots() {
  const double cores = std::max(1u, std::thread::hardware_concurrency());
  double wait = 0.5;
  int64_t scored = 0;
  std::string training;
  std::unique_lock held(mutex_);
  while (!wake_.wait_for(held, std::chrono::duration<double>(wait), [&] { return leaves_; })) {
    wait = 0.5;
    const std::optional<LiveState> state = folder_.state();
    if (state && state->training != training) {
      training = state->training;
      scored = 0;
    }
    if (!state || state->snapshot <= scored) continue;
    held.unlock();
    if (views_.empty()) load_views();
    const double begin = thread_seconds();
    std::optional<double> psnr;
    try {
      psnr = score(folder_.snapshot(state->snapshot));
    } catch (const std::exception&) {  // it was replaced meanwhile
    }
    wait = std::max(wait, (thread_seconds() - begin) / (kShareOfScores * cores));
    held.lock();
    scored = state->snapshot;
    if (psnr && std::isfinite(*psnr)) scores_.emplace_back(state->snapshot_step, *psnr);
  }
}

}  // namespace tessera
