// Compares asked.json with runs/ and the records of jobs.
#include "tools/batch/batch_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "tools/cli/interrupt.h"
#include "tools/jobs/job.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A text or a number as text; "" for anything else.
std::string word_of(const json& entry, const char* key) {
  const json value = entry.value(key, json());
  if (value.is_string()) return value.get<std::string>();
  return value.is_number() ? value.dump() : "";
}

json array_of(const json& object, const char* key) {
  const json value = object.value(key, json::array());
  return value.is_array() ? value : json::array();
}

std::vector<fs::path> sorted_entries(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) entries.push_back(entry.path());
  std::sort(entries.begin(), entries.end());
  return entries;
}

struct JobsOfBatch {
  std::vector<Job> jobs;        // none: of an earlier version
  std::set<std::string> to_do;  // their names
};

JobsOfBatch read_jobs(const fs::path& root, std::vector<std::string>& notes) {
  const JobFolder folder{root, {}};
  JobsOfBatch found;
  if (!fs::exists(folder.list())) return found;
  try {
    found.jobs = read_job_list(folder);
  } catch (const InputError& error) {
    notes.emplace_back(error.what());
  }
  for (const Job& job : jobs_to_do(found.jobs, folder)) found.to_do.insert(job.name);
  return found;
}

std::vector<BatchFailure> read_failures(const fs::path& root, const JobsOfBatch& of_batch) {
  const JobFolder folder{root, {}};
  std::vector<BatchFailure> failures;
  for (const Job& job : of_batch.jobs) {
    if (!of_batch.to_do.contains(job.name)) continue;
    const json record = read_record(folder, job.name);
    if (record.empty() || record.value("done", false)) continue;
    const JobName name = parts_of(job.name);
    BatchFailure failure{name.scene,
                         name.stage,
                         name.variant,
                         name.seed,
                         name.format,
                         {},
                         word_of(record, "message"),
                         ""};
    if (const json exit = record.value("exit_code", json()); exit.is_number_integer())
      failure.exit = exit.get<int64_t>();
    if (fs::is_regular_file(folder.log(job.name)))
      failure.log = folder.log(job.name).lexically_relative(root).string();
    failures.push_back(std::move(failure));
  }
  return failures;
}

bool concerns(const BatchFailure& failure, const BatchRun& run) {
  return failure.scene == run.scene && (failure.preset.empty() || failure.preset == run.preset) &&
         (failure.seed.empty() || failure.seed == fmt::format("{}", run.seed));
}

BatchRun make_run(const BatchFolder& batch, const JobsOfBatch& of_batch, const std::string& scene,
                  const std::string& preset, int64_t seed) {
  BatchRun run{scene, preset, seed, {}, RunState::kMissing, ""};
  const std::string place = fmt::format("{}/{}/seed-{}", scene, preset, seed);
  run.folder = batch.root / "runs" / place;
  const bool is_scored = fs::exists(run.folder / "metrics.json"),
             is_stale = of_batch.to_do.contains("evaluate/" + place);
  if (is_scored && !is_stale) run.state = RunState::kDone;
  for (const BatchFailure& failure : batch.failures) {
    if (!concerns(failure, run)) continue;
    run.error = failure.line();
    if (!failure.unfinished()) run.state = RunState::kFailed;
  }
  run.has_other_result = is_scored && is_stale;
  return run;
}

void add_asked(BatchFolder& batch, const JobsOfBatch& of_batch) {
  for (const json& scene : array_of(batch.asked, "scenes"))
    for (const json& variant : array_of(batch.asked, "variants"))
      for (const json& seed : array_of(batch.asked, "seeds")) {
        if (!scene.is_object() || !variant.is_object() || !seed.is_number_integer()) continue;
        batch.runs.push_back(make_run(batch, of_batch, word_of(scene, "name"),
                                      word_of(variant, "name"), seed.get<int64_t>()));
      }
}

/// Finished runs that are not among the requested ones, by path, to `found`.
void add_found(const BatchFolder& batch, std::vector<BatchRun>& found) {
  std::set<fs::path> known;
  for (const BatchRun& run : batch.runs)
    if (!run.has_other_result) known.insert(run.folder);
  constexpr std::string_view kSeed = "seed-";
  for (const fs::path& scene : sorted_entries(batch.root / "runs"))
    for (const fs::path& preset : sorted_entries(scene))
      for (const fs::path& folder : sorted_entries(preset)) {
        const std::string name = folder.filename().string();
        int64_t seed = 0;
        if (!name.starts_with(kSeed) || known.contains(folder)) continue;
        if (!fs::exists(folder / "metrics.json")) continue;
        const char* const end = name.data() + name.size();
        if (std::from_chars(name.data() + kSeed.size(), end, seed).ptr != end) continue;
        found.push_back(
            make_run(batch, {}, scene.filename().string(), preset.filename().string(), seed));
      }
}

}  // namespace

JobName parts_of(const std::string& job) {
  JobName name;
  std::istringstream parts(job);
  for (std::string* part : {&name.stage, &name.scene, &name.variant, &name.seed, &name.format})
    std::getline(parts, *part, '/');
  if (name.seed.starts_with("seed-")) name.seed = name.seed.substr(5);
  return name;
}

std::string BatchFailure::line() const {
  std::string text = scene.empty() ? rule : fmt::format("{}: {}", scene, rule);
  if (!preset.empty()) text += ", " + preset;
  if (!seed.empty()) text += ", seed " + seed;
  if (!format.empty()) text += ", " + format;
  return fmt::format("{} ({}): {}", text, exit ? fmt::format("exit {}", *exit) : "not ended",
                     message);
}

bool BatchFailure::unfinished() const {
  return !exit || *exit == kExitNotFinished || *exit == kExitInterrupted;
}

int64_t BatchFolder::count(RunState state) const {
  return std::count_if(runs.begin(), runs.end(),
                       [&](const BatchRun& run) { return run.state == state; });
}

std::vector<std::string> BatchFolder::scenes() const {
  std::vector<std::string> names;
  for (const BatchRun& run : runs)
    if (std::find(names.begin(), names.end(), run.scene) == names.end()) names.push_back(run.scene);
  return names;
}

int64_t BatchFolder::whole_scenes() const {
  const std::vector<std::string> names = scenes();
  return std::count_if(names.begin(), names.end(), [&](const std::string& name) {
    return std::all_of(runs.begin(), runs.end(), [&](const BatchRun& run) {
      return run.scene != name || run.state == RunState::kDone;
    });
  });
}

json read_object(const fs::path& file, std::vector<std::string>& notes) {
  if (!fs::is_regular_file(file)) return nullptr;
  json object = json::parse(read_text_file(file), nullptr, false);
  if (object.is_object()) return object;
  notes.push_back(fmt::format("{}: not valid JSON, left out", file.string()));
  return nullptr;
}

BatchFolder read_batch(const fs::path& root) {
  BatchFolder batch;
  batch.root = root;
  if (!fs::exists(root)) throw InputError(fmt::format("{}: no such folder", root.string()));
  if (!fs::exists(root / "batch.yaml") && !fs::exists(root / "runs"))
    throw InputError(
        fmt::format("{}: is no folder of a batch: it has no batch.yaml and no runs; name the "
                    "folder that was given to `tessera batch -o`",
                    root.string()));
  json asked = read_object(root / "asked.json", batch.notes);
  if (!asked.is_null()) batch.asked = std::move(asked);
  const JobsOfBatch of_batch = read_jobs(root, batch.notes);
  batch.failures = read_failures(root, of_batch);
  add_asked(batch, of_batch);
  add_found(batch, batch.asked.empty() ? batch.runs : batch.earlier);
  return batch;
}

std::string batch_summary(const BatchFolder& batch) {
  return fmt::format("{} of {} runs done, {} failed, {} not run; {} of {} scenes complete",
                     batch.count(RunState::kDone), batch.runs.size(),
                     batch.count(RunState::kFailed), batch.count(RunState::kMissing),
                     batch.whole_scenes(), batch.scenes().size());
}

}  // namespace tessera
