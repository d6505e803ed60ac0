// The request of `tessera batch`: captures by name, from a folder or a glob, and batch.yaml, which
// is checked before anything is run. settings.py checks the file again, as it may have been written
// by hand.
#pragma once
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ingest/ingest.h"

namespace tessera {

struct Dataset {
  std::string name;                 // names the results: that of the folder, in safe characters
  std::filesystem::path path;       // absolute
  std::string split = {};           // that is scored; "": what is held out
  bool has_own_test_views = false;  // or is a rig, of which whole cameras are held out
};

/// In the order of the words, those of a folder or glob by name; a folder that is meant twice is
/// taken once; `out`, where the results go, is none of them. A word may end in :test, :val or
/// :train, the split that is scored. A folder that is no capture is taken, too, and fails alone.
/// Errors: InputError: no such folder, a glob that no folder matches, no capture among all, two of
/// one name, a folder with two splits.
std::vector<Dataset> find_datasets(const std::vector<std::string>& words,
                                   const std::filesystem::path& out);

/// Whether --test-every cannot choose the test views of a capture that is read with `options`: a
/// rig of several cameras, a transforms capture with test frames. False where it cannot be read.
bool has_test_views_of_its_own(const std::filesystem::path& capture, const IngestOptions& options);

struct BatchConfig {
  std::vector<Dataset> datasets;
  std::vector<std::string> ingest;             // words of `tessera ingest`
  std::vector<std::string> presets;            // of `tessera train`
  std::string table;                           // of the workflow, instead of presets; or ""
  std::map<std::string, std::string> options;  // of every preset: key → text, as typed
  std::vector<int64_t> budgets;                // most Gaussians; none: those of the presets
  std::vector<int64_t> steps;                  // likewise iterations
  std::vector<int64_t> seeds;
  std::vector<std::string> exports;
  int64_t threads = 1, gpus = 0;  // of a job; of the machine, 0: trains on the CPU
  std::string windows = "auto";   // of `tessera train`
  int64_t window_jobs = 1;        // programs that train the windows of one clip
};

/// The object that batch.yaml holds (JSON, which is YAML): scenes, presets or table and options,
/// budgets, steps, seeds, exports, tessera (this program), threads, gpus, windows, window_jobs,
/// deterministic. Errors: InputError: unknown preset, table, option or format, a value out of
/// range, something named twice.
nlohmann::json batch_yaml(const BatchConfig& config);

}  // namespace tessera
