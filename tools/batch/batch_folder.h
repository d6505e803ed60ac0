// The contents of a batch's folder OUT: the request, the finished runs and the failures. OUT holds
// batch.yaml, asked.json (the resolved request, batch.h), jobs.json with records of jobs and their
// logs (tools/jobs/job.h), scenes/SCENE, runs/SCENE/PRESET/seed-S (run folders with metrics.json
// and train.json), exports/SCENE/PRESET/seed-S/FORMAT, workflow/ and report/.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "kernels/base/enum_names.h"

namespace tessera {

/// What the name of a job says; "" for what it is not of.
struct JobName {
  std::string stage, scene, variant, seed, format;
};
JobName parts_of(const std::string& job);

struct BatchFailure {
  std::string scene, rule, preset, seed, format;  // "" where it is of none
  std::optional<int64_t> exit;                    // nothing: it has not ended, or nobody saw it end
  std::string message;                            // one line
  std::string log;                                // below OUT; "": there is none
  /// "room: train, fast, seed 2 (exit 1): loss is not finite".
  std::string line() const;
  /// It runs, was interrupted, or left for another to go on: no failure by itself.
  bool unfinished() const;
};

enum class RunState { kMissing, kDone, kFailed };
template <>
inline constexpr const char* kEnumNames<RunState>[] = {"missing", "done", "failed"};

struct BatchRun {
  std::string scene, preset;
  int64_t seed = 0;
  std::filesystem::path folder;
  RunState state = RunState::kMissing;
  std::string error;              // of a failure that concerns it
  bool has_other_result = false;  // its folder has the result of an earlier request, and no other
};

struct BatchFolder {
  std::filesystem::path root;
  nlohmann::json asked = nlohmann::json::object();  // asked.json; empty before the first start
  std::vector<BatchRun> runs;                       // scene by scene, in the order of the request
  std::vector<BatchRun> earlier;                    // finished, but not of this request
  std::vector<BatchFailure> failures;               // in the order of the jobs
  std::vector<std::string> notes;                   // what could not be read, one line each

  /// Of the requested runs.
  int64_t count(RunState state) const;
  /// Scenes that have requested runs, in order; and those all of whose runs are done.
  std::vector<std::string> scenes() const;
  int64_t whole_scenes() const;
};

/// Null where there is no such file; an object, or null and a note, where there is.
nlohmann::json read_object(const std::filesystem::path& file, std::vector<std::string>& notes);

/// Where asked.json is missing or damaged, all finished runs count as requested; where jobs.json
/// is, as in folders of earlier versions, a run with scores is done. Errors: InputError: `root` is
/// no folder of a batch: it has neither batch.yaml nor runs/.
BatchFolder read_batch(const std::filesystem::path& root);

/// "10 of 12 runs done, 1 failed, 1 not run; 3 of 4 scenes complete".
std::string batch_summary(const BatchFolder& batch);

}  // namespace tessera
