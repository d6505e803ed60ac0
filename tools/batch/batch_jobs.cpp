// A job of a training has the forecast of its memory and time, with room.
#include "tools/batch/batch_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/prepared/scene_reader.h"
#include "ingest/prepared/transforms_json.h"
#include "recon4d/options/forecast.h"
#include "recon4d/options/presets.h"
#include "tools/batch/batch_folder.h"
#include "tools/cli/stage_ledger.h"
#include "tools/session/device_choice.h"
#include "tools/windows/windows_forecast.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int64_t kProgramMb = 300;  // of the program itself and of images on their way
constexpr double kMemorySpare = 1.5, kTimeSpare = 3;  // the forecast's own factors
constexpr int64_t kLeastMinutes = 10;

class BatchJobs {
 public:
  BatchJobs(const Batch& batch, int64_t at_once)
      : batch_(batch), cards_(batch.gpus == 0 ? 0 : std::max<int64_t>(1, batch.gpus / at_once)) {}

  std::vector<Job> list() {
    for (const BatchScene& scene : batch_.scenes) {
      ingest(scene);
      for (const BatchVariant& variant : batch_.variants)
        for (const int64_t seed : batch_.seeds) results(scene, variant, seed);
    }
    return std::move(jobs_);
  }

 private:
  void add(Job job, int64_t gpus, int64_t memory_mb, int64_t minutes) {
    job.words.insert(job.words.end(), {"--threads", fmt::format("{}", batch_.threads), "--json"});
    job.uses = {gpus, batch_.threads, memory_mb, minutes};
    jobs_.push_back(std::move(job));
  }

  void ingest(const BatchScene& scene) {
    Job job;
    job.name = "ingest/" + scene.name;
    job.words = {"ingest", scene.path.string(), "-o", "scenes/" + scene.name, "--overwrite"};
    job.words.insert(job.words.end(), scene.ingest.begin(), scene.ingest.end());
    const bool says =
        std::find(scene.ingest.begin(), scene.ingest.end(), "--frames-as") != scene.ingest.end();
    if (batch_.windows != "none" && !says)
      job.words.insert(job.words.end(), {"--frames-as", "auto"});
    job.inputs = key_of({{"contents of the capture", file_stamps(scene.path)},
                         {"contents of named files", stamps_of_files(scene.ingest)},
                         {"words", std::vector(job.words.begin() + 4, job.words.end())}});
    job.output = "scenes/" + scene.name + ".json";
    job.product = "scenes/" + scene.name + "/transforms.json";
    add(std::move(job), 0, 2000, 240);
  }

  /// A length is that of the clips that can be cut.
  std::string windows() const {
    const bool is_length = parse_windows(batch_.windows).kind == WindowWish::Kind::kLength;
    return is_length ? "auto:" + batch_.windows : batch_.windows;
  }

  static json stamps_of_files(const std::vector<std::string>& words) {
    json stamps = json::array();
    for (const std::string& word : words)
      if (word.starts_with('/') && fs::exists(word)) stamps.push_back(file_stamps(word));
    return stamps;
  }

  void results(const BatchScene& scene, const BatchVariant& variant, int64_t seed) {
    const std::string place = fmt::format("{}/{}/seed-{}", scene.name, variant.name, seed),
                      run = "runs/" + place;
    const std::string device = batch_.gpus > 0 ? "cuda" : "cpu";
    Job train;
    train.name = "train/" + place;
    train.words = {"train", "scenes/" + scene.name, "-o", run, "--overwrite"};
    TrainArguments arguments = variant.arguments;
    arguments.given["seed"] = fmt::format("{}", seed);
    const std::vector<std::string> options = words_of(arguments);
    train.words.insert(train.words.end(), options.begin(), options.end());
    train.words.insert(train.words.end(), {"--windows", windows(), "--backend", device});
    if (cards_ > 1) train.words.insert(train.words.end(), {"--gpus", fmt::format("{}", cards_)});
    if (!variant.time_limit.empty())
      train.words.insert(train.words.end(), {"--time-limit", variant.time_limit});
    train.needs = {"ingest/" + scene.name};
    train.inputs = key_of({{"preset", arguments.preset},
                           {"ablation", arguments.ablation},
                           {"options", arguments.given},
                           {"windows", batch_.windows}});
    train.output = run + "/train.json";
    add(train, cards_, kProgramMb, kLeastMinutes);

    Job evaluate;
    evaluate.name = "evaluate/" + place;
    evaluate.words = {"evaluate",  run,   "--split", scene.split.empty() ? "auto" : scene.split,
                      "--backend", device};
    evaluate.needs = {train.name};
    evaluate.inputs = evaluate.words[3];
    evaluate.output = run + "/metrics.json";
    add(evaluate, std::min<int64_t>(cards_, 1), kProgramMb, kLeastMinutes);

    for (const std::string& format : batch_.exports) {
      const std::string folder = fmt::format("exports/{}/{}", place, format);
      Job exported;
      exported.name = fmt::format("export/{}/{}", place, format);
      exported.words = {"export", run, "-o", folder, "--format", format};
      exported.needs = {train.name};
      exported.inputs = format;
      exported.output = folder + ".json";
      add(exported, 0, kProgramMb, kLeastMinutes);
    }
  }

  const Batch& batch_;
  const int64_t cards_;  // of a training
  std::vector<Job> jobs_;
};

}  // namespace

std::vector<Job> jobs_of(const Batch& batch, int64_t at_once) {
  return BatchJobs(batch, at_once).list();
}

JobUses forecast_uses(const Job& job, const Batch& batch, const fs::path& folder) {
  const JobName name = parts_of(job.name);
  const fs::path scene_folder = folder / "scenes" / name.scene;
  const auto variant = std::find_if(batch.variants.begin(), batch.variants.end(),
                                    [&](const BatchVariant& v) { return v.name == name.variant; });
  JobUses uses = job.uses;
  if (variant == batch.variants.end() || !is_prepared_scene(scene_folder)) return uses;
  const Scene scene = scene_without_pixels(scene_folder, true);
  ForecastLoad load = forecast_load(scene);
  load.threads = int(job.uses.threads);
  const TrainForecast whole =
      forecast_training(load, resolve_options(variant->arguments, facts_of(scene)).options);
  const bool on_gpu = batch.gpus > 0;
  auto bytes = double(on_gpu ? whole.host_bytes : whole.total_bytes);
  double seconds = on_gpu ? whole.gpu_seconds : whole.cpu_seconds;
  const WindowsForecast windows = forecast_windows(parse_windows(batch.windows), scene,
                                                   machine_memory(), int(job.uses.threads));
  if (windows.windows > 1) {
    const double cards = std::max<double>(1, double(job.uses.gpus));
    bytes = windows.table["host_bytes"].get<double>() * cards;
    seconds = std::max(seconds, windows.table["window_seconds"].get<double>()) *
              std::ceil(double(windows.windows) / cards);
  }
  uses.memory_mb = kProgramMb + int64_t(std::ceil(kMemorySpare * bytes / double(1 << 20)));
  uses.minutes = std::max(kLeastMinutes, int64_t(std::ceil(kTimeSpare * seconds / 60)));
  return uses;
}

}  // namespace tessera
