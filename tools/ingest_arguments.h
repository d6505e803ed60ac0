// What: the ingest part of a command line, shared by `ingest`, `run` and `doctor`.
// Not: the options' meaning (ingest/ingest.h).
#pragma once
#include <string>

#include "ingest/ingest.h"
#include "tools/command.h"

namespace tessera {

struct IngestArguments {
  IngestOptions options;
  std::string poses, sync = "auto", intrinsics = "shared";
};

void add_ingest_options(CLI::App& command, IngestArguments& arguments);
/// Checks what was typed and turns names into values; `capture` decides what --poses colmap means.
/// Errors: InputError.
IngestOptions resolve_ingest(const IngestArguments& arguments,
                             const std::filesystem::path& capture);
/// Everything that changes the prepared scene, for keys of finished work.
nlohmann::json to_json(const IngestOptions& options);
/// Runs `ingest_capture` under a progress bar, prints its warnings.
IngestReport ingest_with_progress(const std::filesystem::path& capture,
                                  const std::filesystem::path& out, const IngestOptions& options);
/// "n3dv", "colmap", …
const char* layout_name(CaptureLayout layout);

}  // namespace tessera
