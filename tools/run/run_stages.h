// The six stages of `tessera run`: ingest, train, evaluate, export, page, report. A stage runs
// once, and again only when its inputs or options change. OUT holds scene/ (unless the capture is a
// prepared scene already), run/, frames/ on request, player/, report/ and stages.json. A run of
// another request is refused; with --overwrite OUT becomes OUT.1, from which the scene is taken
// where it is made of the same.
#pragma once
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "tools/cli/ingest_arguments.h"
#include "tools/cli/train_arguments.h"
#include "tools/live/view_child.h"

namespace tessera {

struct RunRequest {
  std::filesystem::path capture, out;
  IngestArguments ingest;
  TrainArguments training;
  int64_t export_frames = 0;       // PLY frames to write; 0: none
  std::string title, description;  // of the player's page
  std::string windows = "auto";    // --windows, as parse_windows
  int64_t gpus = 1;                // cards that train windows at once
  bool overwrite = false;          // a run of another request becomes OUT.1
  bool json_output = false;
  ViewOptions view;
};

/// Runs what is to be done and returns the results of all stages: those of evaluate at the top
/// level, the others under `training`, `export` and `player`; the seconds of the stages that ran
/// under `stage_seconds`. Nothing when it was interrupted, or its training was stopped by a page
/// that shows it; what is done is kept. `view`: filled where the request has one, something was
/// trained and there was none. Errors: InputError, among them that OUT holds a run of another
/// request.
std::optional<nlohmann::json> run_stages(const RunRequest& request,
                                         std::unique_ptr<ViewChild>& view);

}  // namespace tessera
