// `tessera batch`: many captures with several presets, budgets and seeds, as a list of jobs. It
// writes batch.yaml and the list, runs it here or on a cluster, and writes the report.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <thread>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "ingest/files/json_file.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"
#include "recon4d/options/train_options_json.h"
#include "tools/batch/batch.h"
#include "tools/batch/batch_folder.h"
#include "tools/batch/batch_jobs.h"
#include "tools/batch/batch_watch.h"
#include "tools/batch/captures.h"
#include "tools/batch/engine.h"
#include "tools/batch/write_report.h"
#include "tools/cli/argument_words.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/background_program.h"
#include "tools/cli/ingest_arguments.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/cli/training_terminal.h"
#include "tools/jobs/runner.h"
#include "tools/session/device_choice.h"
#include "tools/session/locks.h"
#include "tools/web/web_page.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct BatchRequest {
  std::vector<std::string> datasets;
  fs::path out;
  std::vector<std::string> presets{TrainArguments{}.preset}, exports{"tessera", "html"};
  std::string table, windows = "auto", checkpoint_every;
  std::vector<int64_t> budgets, steps, seeds{1};
  int64_t threads = 0, gpus = 0, jobs = 0;
  std::string profile, part;
  bool dry_run = false;
  IngestArguments ingest;
  TrainArguments training;
  std::vector<std::string> ingest_options;  // their names
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
    const bool of_engine = name == "--out" || name == "--jobs" || name == "--profile" ||
                           name == "--part" || name == "--dry-run";
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

/// The options of ingest without --test-every, where the capture has test views of its own.
std::vector<std::string> ingest_words_of(const Dataset& dataset, std::vector<std::string> words) {
  const auto option = std::find(words.begin(), words.end(), "--test-every");
  if (dataset.has_own_test_views && words.end() - option >= 2) words.erase(option, option + 2);
  return words;
}

json scenes_of(const CLI::App& command, const BatchRequest& request) {
  std::vector<Dataset> datasets = find_datasets(request.datasets, request.out);
  state_changed_names(datasets);
  pass_over_test_views(resolve_ingest(request.ingest), datasets);  // its errors now
  const std::vector<std::string> words = ingest_words(command, request);
  json scenes = json::array();
  for (const Dataset& dataset : datasets) {
    scenes.push_back({{"name", dataset.name},
                      {"path", dataset.path.string()},
                      {"ingest", ingest_words_of(dataset, words)}});
    if (!dataset.split.empty()) scenes.back()["split"] = dataset.split;
  }
  return scenes;
}

/// What was typed, as batch.yaml has it.
json given_of(const CLI::App& command, const BatchRequest& request) {
  refuse_repeats(request.presets, "--preset");
  json options = request.training.given;
  if (!request.training.ablation.empty()) options["ablation"] = request.training.ablation;
  if (!request.checkpoint_every.empty()) options["checkpoint_every"] = request.checkpoint_every;
  json given = {{"scenes", scenes_of(command, request)},
                {"seeds", request.seeds},
                {"exports", request.exports},
                {"threads", request.threads},
                {"gpus", request.gpus},
                {"windows", request.windows}};
  if (!request.budgets.empty()) given["budgets"] = request.budgets;
  if (!request.steps.empty()) given["steps"] = request.steps;
  if (!request.table.empty()) {
    for (const char* name : {"--preset", "--ablation"})
      if (command.count(name) > 0)
        throw InputError(fmt::format("{} does not go with --table, whose rows have theirs", name));
    given["table"] = request.table;
    given["options"] = options;
    return given;
  }
  for (const std::string& preset : request.presets)
    given["presets"].push_back(
        options.empty() ? json(preset)
                        : json{{"name", preset}, {"preset", preset}, {"options", options}});
  return given;
}

void complete(const CLI::App& command, BatchRequest& request) {
  const bool is_here = request.profile.empty();
  const int64_t cores = std::max(1u, std::thread::hardware_concurrency());
  if (command.count("--threads") == 0)
    request.threads = std::max<int64_t>(cores / std::max<int64_t>(request.jobs, 1), 1);
  if (command.count("--gpus") == 0) request.gpus = is_here && is_cuda_chosen("auto") ? 1 : 0;
  if (command.count("--exports") == 0 && !carries_pages()) request.exports = {"tessera"};
}

/// The object of batch.yaml, as it is there or as it is to be written.
json given_batch(const CLI::App& command, BatchRequest& request) {
  const fs::path file = request.out / "batch.yaml";
  if (request.datasets.empty()) {
    refuse_settings(command);
    return read_batch_file(file);
  }
  if (fs::exists(file) && !json::accept(read_text_file(file)))
    throw InputError(fmt::format(
        "{}: was written by hand and would be replaced; leave out the captures to go on with it, "
        "or move it away",
        file.string()));
  complete(command, request);
  return given_of(command, request);
}

/// Of every Nth scene from the Ith, where `part` is "I/N".
std::vector<Job> jobs_of_part(std::vector<Job> jobs, const Batch& batch, const std::string& part) {
  if (part.empty()) return jobs;
  unsigned first = 0, step = 0;
  if (std::sscanf(part.c_str(), "%u/%u", &first, &step) != 2 || first >= step)
    throw InputError(fmt::format("--part {}: expected I/N with I below N, for instance 0/4", part));
  std::vector<std::string> scenes;
  for (size_t i = first; i < batch.scenes.size(); i += step) scenes.push_back(batch.scenes[i].name);
  std::erase_if(jobs, [&](const Job& job) {
    return std::find(scenes.begin(), scenes.end(), parts_of(job.name).scene) == scenes.end();
  });
  return jobs;
}

/// What has failed is tried again: it fails now, or not.
void forget_failures(const std::vector<Job>& to_do, const JobFolder& folder) {
  std::error_code ignored;
  for (const Job& job : to_do) {
    const json code = read_record(folder, job.name).value("exit_code", json());
    if (code.is_number() && code != kExitNotFinished && code != kExitInterrupted)
      fs::remove(folder.record(job.name), ignored);
  }
}

/// On this machine. Returns an exit code: what failed is in the records.
int run_here(const BatchRequest& request, const Batch& batch, const std::vector<Job>& jobs,
             const JobFolder& folder, BatchWatch& watch) {
  const int64_t at_once = request.jobs > 0 ? request.jobs : std::max<int64_t>(1, batch.gpus);
  JobSlots slots{{}, at_once * batch.threads, machine_memory() >> 20};
  slots.gpus.resize(size_t(batch.gpus));
  std::iota(slots.gpus.begin(), slots.gpus.end(), 0);
  ProgressBar bar("batch");
  int64_t ended = 0, count = 0;
  JobsObserver observer;
  observer.uses = [&](const Job& job) { return forecast_uses(job, batch, folder.root); };
  observer.on_start = [&](const Job&, int64_t, int64_t all) { count = all; };
  observer.on_end = [&](const Job&, const JobOutcome&) { ++ended; };
  observer.on_look = [&](const std::vector<std::string>& running) {
    watch.tick();
    bar.update(ended, count, fmt::format("{}", fmt::join(running, ", ")));
  };
  observer.signal = stop_signal;
  return run_jobs(jobs, folder, slots, observer).all_done() ? kExitDone : kExitFailed;
}

int run_on_cluster(const std::vector<std::string>& arguments, const std::vector<Job>& to_do,
                   const JobFolder& folder, BatchWatch& watch) {
  std::error_code ignored;
  for (const Job& job : to_do) fs::remove(folder.root / "jobs" / (job.name + ".ok"), ignored);
  const fs::path log = folder.root / "logs" / "snakemake.log";
  say(fmt::format("batch: {}; its words are in {}", shell_line(arguments), log.string()));
  const int code = run_engine(arguments, log, interrupted, [&] { watch.tick(); });
  if (code != 0 && !interrupted())
    warn(fmt::format("batch: snakemake has left with exit code {}: {}", code, log.string()));
  return code;
}

int finish(const BatchRequest& request, const Batch& batch, int code) {
  if (interrupted()) {
    print_result(false, {},
                 fmt::format("batch: {}; interrupted: run the same command again to go on",
                             batch_summary(read_batch(request.out))));
    return stop_code();
  }
  if (!request.part.empty()) return code;
  const BatchFolder found = read_batch(request.out);
  const fs::path page = request.out / "report" / (carries_pages() ? "index.html" : "report.json");
  write_report({request.out, true, batch.gpus > 0 ? "cuda" : "cpu"});
  print_result(false, {},
               fmt::format("batch: {}; report: {}", batch_summary(found), page.string()));
  const bool whole = found.count(RunState::kDone) == int64_t(found.runs.size());
  return whole && found.failures.empty() && code == 0 ? kExitDone : kExitFailed;
}

int batch(const CLI::App& command, BatchRequest& request) {
  request.out = fs::absolute(request.out / "").lexically_normal().parent_path();
  const json given = given_batch(command, request);
  const Batch batch = resolve_batch(given, request.out);
  std::vector<std::string> engine;
  if (!request.profile.empty())
    engine = engine_arguments(request.out, request.profile, request.jobs);
  const JobFolder folder{request.out, this_program()};
  const int64_t at_once = !engine.empty() ? 1 : request.jobs > 0 ? request.jobs : batch.gpus;
  const std::vector<Job> all = jobs_of(batch, std::max<int64_t>(1, at_once)),
                         jobs = jobs_of_part(all, batch, request.part);
  const std::vector<Job> to_do = jobs_to_do(jobs, folder);
  if (request.dry_run) {
    std::vector<std::string> names;
    for (const Job& job : to_do) names.push_back(job.name);
    print_result(false, {},
                 names.empty() ? "nothing is to do" : fmt::format("{}", fmt::join(names, "\n")));
    return kExitDone;
  }
  TrainingTerminal messages;
  std::optional<RunLock> lock;
  if (request.part.empty()) lock.emplace(request.out, messages);
  if (!request.datasets.empty())
    write_text_file(request.out / "batch.yaml", json_text(given, 2) + "\n");
  write_workflow(request.out / "workflow");
  write_text_file(request.out / "asked.json", json_text(to_json(batch), 1) + "\n");
  write_job_list(all, folder);
  forget_failures(to_do, folder);
  BatchWatch watch(request.out);
  say(fmt::format("batch: {} of {} jobs are to do", to_do.size(), jobs.size()));
  const int code = engine.empty() ? run_here(request, batch, jobs, folder, watch)
                                  : run_on_cluster(engine, to_do, folder, watch);
  watch.look();
  return finish(request, batch, code);
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
  const auto list = [&](const char* name, auto& values, const char* doc) {
    command.add_option(name, values, doc)
        ->delimiter(',')
        ->allow_extra_args(false)
        ->capture_default_str();
  };
  list("--preset", request.presets, "of `tessera train`, a column of the report each");
  command.add_option("--table", request.table,
                     fmt::format("of published figures, a column for each of its rows:{}",
                                 fmt::join(table_lines(), "")));
  list("--steps", request.steps, "iterations: every preset is trained with each of them");
  list("--budgets", request.budgets, "most Gaussians: every preset is trained with each of them");
  list("--seeds", request.seeds, "a training each; the report has medians");
  list("--exports", request.exports, "formats of `tessera export`");
  command.add_option("--ablation", request.training.ablation, "of `tessera train`");
  command.add_option("--checkpoint-every", request.checkpoint_every, "of `tessera train`");
  command.add_option("--threads", request.threads, "of a job; default: cores by --jobs");
  command
      .add_option("--windows", request.windows,
                  "of `tessera train`: auto, none, or a length: long clips in windows, 5s")
      ->capture_default_str();
  command.add_option("--gpus", request.gpus,
                     "of this machine, which jobs share, or of a node; 0: trains on the CPU; "
                     "default: 1 where this machine has one and there is no --profile");
  command
      .add_option("--jobs", request.jobs,
                  "at a time; of this machine's cores each has its share. Default: one a GPU here, "
                  "the profile's on a cluster")
      ->check(CLI::Range(int64_t{1}, int64_t{100000}));
  command.add_option("--profile", request.profile,
                     "a cluster by Snakemake: slurm, or a folder with its config.yaml; default: "
                     "this machine");
  command.add_option("--part", request.part,
                     "I/N: every Nth scene from the Ith, without the report; for job arrays");
  command.add_flag("--dry-run", request.dry_run, "print the jobs that are to do");
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
  command->add_option("-o,--out", request->out, "folder of the batch")->required();
  add_batch_options(*command, *request);
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
