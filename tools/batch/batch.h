// What a batch is asked for, resolved: captures × variants × seeds. batch.yaml has it as a person
// or `tessera batch` writes it, asked.json as it is resolved.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/cli/train_arguments.h"

namespace tessera {

struct BatchScene {
  std::string name;  // of its results
  std::filesystem::path path;
  std::vector<std::string> ingest;  // words of `tessera ingest`
  std::string split;                // that is scored; "": what is held out, else training views
};

/// A preset with its options: a column of the report.
struct BatchVariant {
  std::string name;
  TrainArguments arguments;
  std::string time_limit;  // of `tessera train`; or ""
  std::string label;       // of a row of a table, as the report shows it; or ""
  nlohmann::json published = nlohmann::json::array();  // figures of others
};

struct Batch {
  std::vector<BatchScene> scenes;
  std::vector<BatchVariant> variants;
  std::vector<int64_t> seeds;
  std::vector<std::string> exports;  // formats
  int64_t threads = 1;               // of a job
  int64_t gpus = 0;                  // of this machine or of a node; 0: trains on the CPU
  std::string windows = "auto";      // of `tessera train`
};

/// The object of batch.yaml: {scenes, captures, presets, table, options, seeds, budgets, steps,
/// exports, threads, gpus, deterministic, windows}. `folder`: where it lies; paths start there, and
/// results are written below it. Looks at captures, at what options may be, and writes nothing.
/// Errors: InputError naming key, value and remedy.
Batch resolve_batch(const nlohmann::json& given, const std::filesystem::path& folder);

/// Errors: InputError: not there, neither JSON nor YAML, no object.
nlohmann::json read_batch_file(const std::filesystem::path& file);

/// {scenes, variants, seeds, exports, windows}, as the report reads it.
nlohmann::json to_json(const Batch& batch);

/// A variant for each of `presets`, or of the rows of `table`, with each of `budgets` and `steps`.
/// Errors: InputError: unknown names, values that no training takes, two of one name.
std::vector<BatchVariant> read_variants(const nlohmann::json& given);

}  // namespace tessera
