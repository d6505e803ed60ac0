// Looks for pages in their order, and exports one where there is none.
#include "tools/commands/view_source.h"

#include <nlohmann/json.hpp>

#include "static3d/transform/world_change.h"
#include "tools/cli/terminal.h"
#include "tools/export/in_time.h"
#include "tools/export/player_files.h"
#include "tools/session/model_input.h"
#include "tools/session/run_folder.h"
#include "tools/session/run_lock.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// Of the folders in which commands leave pages, in this order: run and export, run, batch.
constexpr const char* kPagePlaces[] = {"", "player", "report"};

ViewSource made_page(const std::string& path) {
  ModelInput input = load_model_input(path);
  for (const std::string& warning : input.warnings) warn(warning);
  input.model = model_in_source_world(input.model);
  ViewSource source;
  source.kind = "model";
  source.temporary = std::make_unique<TemporaryFolder>("view");
  source.folder = source.temporary->path() / "page";
  ExportRequest page;
  page.model = path;
  page.out = source.folder.string();
  page.format = "page";
  find_time_format(page.format)->write(page, input.model);
  return source;
}

}  // namespace

ViewSource view_source(const std::string& path) {
  if (const fs::path run = run_folder_of(path); is_run_locked(run)) {
    ViewSource source;
    source.folder = path;
    source.start = "/live";
    source.kind = "training";
    source.run = run;
    return source;
  }
  for (const fs::path place : kPagePlaces) {
    if (!fs::is_regular_file(path / place / kPageFile)) continue;
    ViewSource source;
    source.folder = path;
    source.start = place.empty() ? "/" : "/" + place.string() + "/";
    source.kind = "finished";
    return source;
  }
  return made_page(path);
}

}  // namespace tessera
