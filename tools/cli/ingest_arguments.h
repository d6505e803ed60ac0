// The ingest options of the command line, shared by `ingest`, `run` and `doctor`. ingest/ingest.h
// documents their meaning.
#pragma once
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ingest/ingest.h"
#include "tools/cli/command.h"

namespace tessera {

struct IngestArguments {
  IngestOptions options;
  /// By option, what was typed of those whose words are no numbers.
  std::map<std::string, std::vector<std::string>> words{};
};

void add_ingest_options(CLI::App& command, IngestArguments& arguments);
/// Checks what was typed and turns words into values. Errors: InputError.
IngestOptions resolve_ingest(const IngestArguments& arguments);
/// Errors: InputError that names the captures in `folder`, where it holds some and is none itself,
/// or what a training wrote there.
void require_one_capture(const std::filesystem::path& folder, const IngestOptions& options);
/// Everything that changes the prepared scene, with the stamps of the files that are named: what
/// keys of finished work are made of.
nlohmann::json to_json(const IngestOptions& options);
/// Runs `ingest_capture` under a progress bar, its cloud on `backend` (backend_options.h); prints
/// its notes, the table of cameras, and its warnings.
IngestReport ingest_with_progress(const std::filesystem::path& capture,
                                  const std::filesystem::path& out, const IngestOptions& options,
                                  const std::string& backend);

}  // namespace tessera
