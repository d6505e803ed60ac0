// The report of a run as files: index.html, run.json, and each chart as SVG.
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>

#include "kernels/backend.h"

namespace tessera {

struct RunReportRequest {
  std::filesystem::path run;  // a run folder, or the OUT of `tessera run`
  std::filesystem::path out;  // empty: report/ in `run`
  /// Called once, where there is a model whose views can be rendered.
  std::function<std::unique_ptr<Backend>()> backend;
};

/// Whether the folder holds a run, as for `run` of a request.
bool is_run(const std::filesystem::path& folder);

/// Writes the files and returns what run.json holds, with `page`, the path of index.html. A run
/// without metrics.json is scored for it. What cannot be rendered, for example because the scene is
/// gone, is named in the page. Errors: InputError: no run, the folder cannot be written.
nlohmann::json write_run_report(const RunReportRequest& request);

}  // namespace tessera
