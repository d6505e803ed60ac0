// The report of runs as files: report.json, its images, and the page that shows them.
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "kernels/backend.h"
#include "tools/report/rendered_views.h"

namespace tessera {

struct RunReportRequest {
  /// Run folders, folders of a clip in windows, or the OUT of `tessera run`; one or more.
  std::vector<std::filesystem::path> runs;
  std::filesystem::path out;  // of one run alone it may be empty: report/ in it
  /// Called where there is a model whose views can be rendered.
  std::function<std::unique_ptr<Backend>()> backend;
  bool overwrite = false;  // the folder may have contents that no report has written
};

/// Whether the folder holds a run, as for `runs` of a request.
bool is_run(const std::filesystem::path& folder);

/// Writes the files and returns what report.json holds, with `page`, the path of index.html, or in
/// a build without web pages that of report.json. A run without metrics.json is scored for it. What
/// cannot be rendered, for example because the scene is gone, is named in the report. Several runs
/// are compared. Errors: InputError: no run; the folder has other contents, or cannot be written.
nlohmann::json write_run_report(const RunReportRequest& request);

}  // namespace tessera
