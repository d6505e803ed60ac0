// Schedules the reads of requests and the copies of the model, and encodes snapshots on a thread of
// low priority.
#include "tools/live/live_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <random>
#include <thread>
#include <utility>

#include "kernels/base/parallel.h"
#include "kernels/base/seconds_since.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/live/live_folder.h"

namespace tessera {
namespace {

constexpr auto kLookEvery = std::chrono::seconds(1);
constexpr auto kWatchedFor = std::chrono::seconds(10);  // after the last request
constexpr double kLeastPause = 3;                       // seconds
constexpr double kShareOfCopies = 0.01;                 // of the time, that copies may take
constexpr double kShareBesideDevice = 0.1;              // of the cores
constexpr int kFastGzip = 1;

std::string random_id() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

/// What a player shows of the scene, in whose world the model trains.
Tessera4dOptions file_options(const Scene& scene) {
  std::vector<NamedView> views;
  for (const Frame& frame : scene.frames) views.push_back({frame.name, {frame.camera, frame.time}});
  const Rig rig = rig_of_views(views, scene.time_axis);
  Tessera4dOptions options;
  options.gzip_level = kFastGzip;
  options.cameras = rig.cameras;
  options.fps = rig.fps;
  return options;
}

constexpr int kNiceOfSnapshots = 10;

}  // namespace

LiveTraining::LiveTraining(SessionObserver& inner, const std::filesystem::path& run,
                           std::function<void()> begun)
    : inner_(inner), folder_(run), begun_(std::move(begun)) {
  state_.training = random_id();
}

LiveTraining::~LiveTraining() {
  if (!writer_) return;
  writer_.reset();
  folder_.remove();
}

void LiveTraining::on_step(const SessionStep& step) {
  state_.step = step.report.iteration;
  state_.total = step.total;
  state_.loss = step.report.loss;
  state_.steps_per_second = step.steps_per_second;
  state_.seconds_left = step.seconds_left;
  state_.num_static = step.report.num_static;
  state_.num_dynamic = step.report.num_dynamic;
  state_.device_bytes = step.report.peak_bytes;
  inner_.on_step(step);
}

void LiveTraining::begin(const Scene& scene, const TrainOptions& options) {
  folder_.remove();  // of a training that was killed
  writer_ = std::make_unique<SnapshotWriter>(folder_, options, file_options(scene));
  if (begun_) begun_();
}

void LiveTraining::look() {
  looked_ = Clock::now();
  const std::optional<LiveRequest> request = folder_.request();
  if (request && request->counter != request_counter_) {
    request_counter_ = request->counter;
    seen_ = request->seen;
    asked_ = looked_;
    watched_ = true;
    stopped_ = stopped_ || request->stop_training == state_.training;
  }
  watched_ = watched_ && looked_ - asked_ < kWatchedFor;
  if (!watched_) return;
  if (!writer_->busy()) {
    if (writer_->written() > state_.snapshot) state_.snapshot_step = copied_step_;
    state_.snapshot = writer_->written();
    state_.model_failure = writer_->failure();
  }
  ++state_.counter;
  folder_.write(state_);
}

double LiveTraining::pause_between_snapshots() const {
  const double cores = std::max(1u, std::thread::hardware_concurrency());
  const double share = on_device_ ? kShareBesideDevice : kShareOfCopies;
  return std::max(
      {kLeastPause, copy_seconds_ / kShareOfCopies, writer_->seconds() / cores / share});
}

bool LiveTraining::due() {
  if (!writer_) return false;
  if (Clock::now() - looked_ >= kLookEvery) look();
  if (!watched_ || writer_->busy() || seen_ < state_.snapshot) return false;
  return copied_step_ == 0 || seconds_since(taken_) >= pause_between_snapshots();
}

void LiveTraining::take(const TrainState& state) {
  const Clock::time_point start = Clock::now();
  TrainState copy;
  copy.model = state.model.clone_values();
  for (int k = 0; k < 2; ++k)
    copy.statistics[k].filter_size.copy_from(state.statistics[k].filter_size);
  on_device_ = &state.model.static_set.memory() != &host_memory();
  copy_seconds_ = seconds_since(start);
  taken_ = Clock::now();
  copied_step_ = state.iteration;
  writer_->start(std::move(copy), writer_->written() + 1);
}

SnapshotWriter::SnapshotWriter(LiveFolder folder, TrainOptions options, Tessera4dOptions file)
    : folder_(std::move(folder)), options_(std::move(options)), file_(std::move(file)) {}

SnapshotWriter::~SnapshotWriter() {
  if (thread_.joinable()) thread_.join();
}

void SnapshotWriter::start(TrainState state, int64_t number) {
  if (thread_.joinable()) thread_.join();
  busy_ = true;
  thread_ = std::thread([this, number, held = std::move(state)]() mutable {
    lower_priority(kNiceOfSnapshots);
    const double begin = thread_seconds();
    try {
      write(held, number);
      failure_.clear();
    } catch (const std::exception& error) {  // the training continues without it
      failure_ = error.what();
    }
    seconds_ = thread_seconds() - begin;
    busy_ = false;
  });
}

void SnapshotWriter::write(TrainState& state, int64_t number) {
  const SerialSection serial;
  const GaussianModel model = baked_model(std::move(state), options_);
  if (!folder_.write_snapshot(number, single_tessera4d(encode_tessera4d(model, file_)))) return;
  written_ = number;
  std::error_code absent;
  std::filesystem::remove(folder_.snapshot(number - 2), absent);
}

}  // namespace tessera
