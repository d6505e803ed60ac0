// What: what `tessera batch` was asked for → batch.yaml, checked before anything is run.
// Not: the command line (commands/batch.cpp) nor the workflow, which checks again (settings.py): a
//      person may have written the file.
#pragma once
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/batch/datasets.h"

namespace tessera {

struct BatchConfig {
  std::vector<Dataset> datasets;
  std::vector<std::string> ingest;             // words of `tessera ingest`
  std::vector<std::string> presets;            // of `tessera train`
  std::map<std::string, std::string> options;  // of every preset: key → text, as typed
  std::vector<int64_t> budgets;                // most Gaussians; none: as the presets say
  std::vector<int64_t> seeds;
  std::vector<std::string> exports;
  int64_t threads = 1, gpus = 0;  // of a job; of the machine, 0: trains on the CPU
};

/// The object that batch.yaml holds (JSON, which is YAML): scenes, presets, budgets, seeds,
/// exports, tessera (this program), threads, gpus, deterministic. Errors: InputError: unknown
/// preset, option or format, a value out of range, something named twice.
nlohmann::json batch_yaml(const BatchConfig& config);

}  // namespace tessera
