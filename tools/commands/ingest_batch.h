// `tessera ingest` on a folder whose subfolders are captures: one prepared scene each.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ingest/ingest.h"

namespace tessera {

enum class BatchOutcome { kDone, kUnchanged, kFailed };

/// One line of the summary.
struct BatchScene {
  std::string name;  // of the subfolder, and of the prepared scene in the output folder
  BatchOutcome outcome = BatchOutcome::kFailed;
  IngestReport report;  // where it did not fail
  double seconds = 0;
  std::string error;  // where it failed: one line
};

struct BatchResult {
  std::vector<BatchScene> scenes;  // in the order of names
  bool interrupted = false;        // the scenes are those that were reached

  int64_t count(BatchOutcome outcome) const;
};

/// Prepares every subfolder of `folder` into out/NAME. A bad one is reported and the next begun;
/// one that was prepared before from the same files with the same options is left alone
/// (out/scenes.json keeps the keys). `overwrite`: also scenes of those names that it did not
/// prepare are replaced. Errors: InputError when no subfolder is a capture, `out` lies in one of
/// them or cannot be written.
BatchResult ingest_batch(const std::filesystem::path& folder, const std::filesystem::path& out,
                         const IngestOptions& options, bool overwrite);

std::string batch_table(const BatchResult& result);
nlohmann::json batch_json(const BatchResult& result, const std::filesystem::path& out);

}  // namespace tessera
