// `tessera batch`: many captures with several presets, budgets and seeds. It writes batch.yaml and
// the workflow, whose jobs are commands of this program, runs its engine, and prints a summary.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"
#include "recon4d/options/train_options_json.h"
#include "tools/batch/batch_config.h"
#include "tools/batch/batch_folder.h"
#include "tools/batch/batch_watch.h"
#include "tools/batch/engine.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/command.h"
#include "tools/cli/ingest_arguments.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/cli/train_arguments.h"
#include "tools/session/device_choice.h"
#include "tools/web/web_page.h"
#include "tools/windows/window_choice.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kTablePreset = "faster-gs";  // by which options beside a table are checked

struct BatchRequest {
  std::vector<std::string> datasets;
  EngineRequest engine;
  BatchConfig config;
  IngestArguments ingest;
  TrainArguments training;
  std::vector<std::string> ingest_options;  // their names
  std::string checkpoint_every;
};

/// What `tessera ingest` is to be given, from what was typed here; files by their whole path.
std::vector<std::string> ingest_words(const CLI::App& command, const BatchRequest& request) {
  std::vector<std::string> words;
  for (const std::string& name : request.ingest_options) {
    const CLI::Option& option = *command.get_option(name);
    if (option.count() == 0) continue;
    words.push_back(name);
    if (option.get_items_expected_max() == 0) continue;  // a flag
    std::string value = fmt::format("{}", fmt::join(option.results(), ","));
    const bool is_file = name == "--poses" || name == "--offsets" || name == "--masks";
    words.push_back(is_file && fs::exists(value) ? fs::absolute(value).lexically_normal().string()
                                                 : value);
  }
  const auto motion = request.training.given.find("motion");
  if (motion != request.training.given.end() &&
      train_options_from_json({{"motion", motion->second}}).motion == Motion::kNone)
    words.push_back("--static");
  return words;
}

/// Without datasets batch.yaml stays as it is, and nothing that would change it may be typed.
void refuse_settings(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    const bool of_engine =
        name == "--out" || name == "--jobs" || name == "--profile" || name == "--dry-run";
    if (option->count() > 0 && !of_engine)
      throw InputError(fmt::format(
          "{} goes with datasets; without them batch goes on with OUT/batch.yaml as it is", name));
  }
}

/// One line for each capture whose results have another name than its folder.
void state_changed_names(const std::vector<Dataset>& datasets) {
  for (const Dataset& dataset : datasets)
    if (const std::string folder = dataset.path.filename().string(); dataset.name != folder)
      say(fmt::format("batch: the results of '{}' are named '{}'", folder, dataset.name));
}

/// Marks captures to which --test-every does not apply, and names them.
void pass_over_test_views(const IngestOptions& options, std::vector<Dataset>& datasets) {
  if (!options.test_every) return;
  std::vector<std::string> names;
  for (Dataset& dataset : datasets) {
    dataset.has_own_test_views = has_test_views_of_its_own(dataset.path, options);
    if (dataset.has_own_test_views) names.push_back(dataset.name);
  }
  if (!names.empty())
    say(
        fmt::format("batch: --test-every is passed over for {}: rigs, of which whole cameras are "
                    "held out, or captures that state their test views; `scenes:` of batch.yaml "
                    "gives each capture options of its own",
                    listed_names(names)));
}

/// Its rows have theirs.
void refuse_with_table(const CLI::App& command) {
  for (const char* name : {"--preset", "--ablation"})
    if (command.count("--table") > 0 && command.count(name) > 0)
      throw InputError(fmt::format("{} does not go with --table, whose rows have theirs", name));
}

void complete(const CLI::App& command, BatchRequest& request) {
  BatchConfig& config = request.config;
  parse_windows(config.windows);  // its error now
  config.options = request.training.given;
  if (!request.training.ablation.empty()) config.options["ablation"] = request.training.ablation;
  if (!request.checkpoint_every.empty())
    config.options["checkpoint_every"] = request.checkpoint_every;
  pass_over_test_views(resolve_ingest(request.ingest), config.datasets);  // its errors now
  config.ingest = ingest_words(command, request);
  if (!config.table.empty()) config.presets = {kTablePreset};
  const EngineRequest& engine = request.engine;
  if (command.count("--threads") == 0)
    config.threads = std::max<int64_t>(engine.cores / std::max<int64_t>(engine.jobs, 1), 1);
  if (command.count("--gpus") == 0)
    config.gpus = runs_here(engine) && is_cuda_chosen("auto") ? 1 : 0;
  request.engine.gpus = config.gpus;
  if (command.count("--window-jobs") == 0) config.window_jobs = std::max<int64_t>(config.gpus, 1);
  if (command.count("--exports") == 0 && !carries_pages()) config.exports = {"tessera"};
}

/// What `tessera batch` wrote; null where a person did, or nobody.
json own_yaml(const fs::path& file) {
  if (!fs::exists(file)) return nullptr;
  const json yaml = json::parse(read_text_file(file), nullptr, false);
  return yaml.is_object() ? yaml : json();
}

/// batch.yaml and workflow/ in the output folder. A dry run writes its settings beside batch.yaml.
void write_batch(const CLI::App& command, BatchRequest& request) {
  EngineRequest& engine = request.engine;
  const fs::path file = engine.out / engine.file;
  const json config = own_yaml(file);
  if (request.datasets.empty()) {
    refuse_settings(command);
    if (!fs::exists(file))
      throw InputError(
          fmt::format("{}: is not there; name the captures of the batch", file.string()));
    engine.gpus = command.count("--gpus") > 0 || !config.is_object()
                      ? request.config.gpus
                      : config.value("gpus", int64_t{0});
  } else {
    if (fs::exists(file) && !config.is_object())
      throw InputError(fmt::format(
          "{}: was written by hand and would be replaced; leave out the captures to go on with it, "
          "or move it away",
          file.string()));
    request.config.datasets = find_datasets(request.datasets, engine.out);
    state_changed_names(request.config.datasets);
    refuse_with_table(command);
    complete(command, request);
    const std::string text = batch_yaml(request.config).dump(2) + "\n";
    make_folder(engine.out);
    if (engine.dry_run) engine.file = "batch.dry-run.yaml";
    if (config.dump(2) + "\n" != text || engine.dry_run)
      write_text_file(engine.out / engine.file, text);
  }
  write_workflow(engine.out / "workflow");
}

int finish(const fs::path& out, int engine_code) {
  const BatchFolder batch = read_batch(out);
  const bool whole = batch.count(RunState::kDone) == int64_t(batch.runs.size());
  std::string text = "batch: " + batch_summary(batch);
  if (interrupted())
    text += "; interrupted: run the same command again to go on";
  else if (!whole || !batch.failures.empty())
    text += fmt::format("; why: {}, {}", (out / "report" / "index.html").string(),
                        (out / "failures").string());
  else if (engine_code != 0)
    text += fmt::format("; the engine has left with exit code {}: see above", engine_code);
  else
    text += fmt::format("; report: {}", (out / "report" / "index.html").string());
  print_result(false, {}, text);
  if (interrupted()) return stop_code();
  return whole && engine_code == 0 ? kExitDone : kExitFailed;
}

int batch(const CLI::App& command, BatchRequest& request) {
  EngineRequest& engine = request.engine;
  engine.out = fs::absolute(engine.out).lexically_normal();
  engine.cores = std::max(1u, std::thread::hardware_concurrency());
  engine.memory_mb = machine_memory() >> 20;
  check_engine(engine);
  write_batch(command, request);
  const std::vector<std::string> arguments = engine_arguments(engine);
  if (!has_snakemake()) say("snakemake is not installed: the jobs run one after the other");
  say(shell_line(arguments));
  BatchWatch watch(engine.out);
  const int code = run_engine(arguments, interrupted, [&] { watch.tick(); });
  if (engine.dry_run && !request.datasets.empty()) fs::remove(engine.out / engine.file);
  if (interrupted() && engine.dry_run) return stop_code();
  if (code == kExitBadInput || engine.dry_run) return code;  // the workflow has printed why
  watch.look();
  return finish(engine.out, code);
}

/// "\n    NAME  what it compares" of each table.
std::vector<std::string> table_lines() {
  std::vector<std::string> lines;
  for (const auto& [name, text] : workflow_tables())
    lines.push_back(
        fmt::format("\n    {:<13} {}", name, json::parse(text).at("doc").get<std::string>()));
  return lines;
}

void add_batch_options(CLI::App& command, BatchRequest& request) {
  BatchConfig& config = request.config;
  config.presets = {TrainArguments{}.preset};
  config.seeds = {1};
  config.exports = {"tessera", "html"};
  const auto list = [&](const char* name, auto& values, const char* doc) {
    command.add_option(name, values, doc)
        ->delimiter(',')
        ->allow_extra_args(false)
        ->capture_default_str();
  };
  list("--preset", config.presets, "of `tessera train`, a column of the report each");
  command.add_option("--table", config.table,
                     fmt::format("of published figures, a column for each of its rows:{}",
                                 fmt::join(table_lines(), "")));
  list("--steps", config.steps, "iterations: every preset is trained with each of them");
  list("--budgets", config.budgets, "most Gaussians: every preset is trained with each of them");
  list("--seeds", config.seeds, "a training each; the report has medians");
  list("--exports", config.exports, "formats of `tessera export`");
  command.add_option("--ablation", request.training.ablation, "of `tessera train`");
  command.add_option("--checkpoint-every", request.checkpoint_every, "of `tessera train`");
  command.add_option("--threads", config.threads, "of a job; default: cores by --jobs");
  command
      .add_option("--windows", config.windows,
                  "of `tessera train`: auto, none, or a length: long clips in windows, 5s")
      ->capture_default_str();
  command.add_option("--window-jobs", config.window_jobs,
                     "jobs that share the windows of one clip; default: --gpus");
  command.add_option("--gpus", config.gpus,
                     "of this machine or of a node; 0: trains on the CPU; default: 1 where this "
                     "machine has one and the profile is local");
}

void add_engine_options(CLI::App& command, EngineRequest& engine) {
  command
      .add_option("--jobs", engine.jobs,
                  "at a time; of this machine's cores each has its share. Default: one here, the "
                  "profile's on a cluster")
      ->check(CLI::Range(int64_t{1}, int64_t{100000}));
  command
      .add_option("--profile", engine.profile,
                  "local, slurm, or a folder with a config.yaml of Snakemake")
      ->capture_default_str();
  command.add_flag("--dry-run", engine.dry_run, "say what would be run");
}

}  // namespace

void add_batch_command(CLI::App& app, Work& work) {
  const auto request = std::make_shared<BatchRequest>();
  CLI::App* const command = app.add_subcommand(
      "batch",
      "reconstruct many captures with many presets here or on a cluster; repeat it to resume");
  command->add_option("datasets", request->datasets,
                      "captures, folders of captures, globs; PATH:val is scored on that split; "
                      "without any OUT/batch.yaml as it is");
  command->add_option("-o,--out", request->engine.out, "folder of the batch")->required();
  add_batch_options(*command, *request);
  add_engine_options(*command, request->engine);
  const std::vector<CLI::Option*> before = command->get_options();
  add_ingest_options(*command, request->ingest);
  for (const CLI::Option* option : command->get_options())
    if (std::find(before.begin(), before.end(), option) == before.end())
      request->ingest_options.push_back(option->get_name());
  add_option_table(*command, request->training);
  command->callback([request, command, &work] {
    work = [request, command] { return batch(*command, *request); };
  });
}

}  // namespace tessera
