// Reads the files of a run, renders its views, and writes the page with its charts.
#include "tools/report/write_run_report.h"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "recon4d/evaluation/evaluate.h"
#include "recon4d/model/model_file.h"
#include "recon4d/training/scene_scale.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/report/report_page.h"
#include "tools/session/locks.h"
#include "tools/session/run_folder.h"
#include "tools/web/page_words.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Null where the file is missing or damaged: a report contains what is there.
json json_if_sound(const fs::path& file) {
  if (!fs::is_regular_file(file)) return nullptr;
  json content = json::parse(read_text_file(file), nullptr, false);
  return content.is_discarded() ? json() : content;
}

/// Where the files of a run lie.
struct RunPlaces {
  RunFolder run;
  fs::path out;     // of `tessera run`; empty for a run folder alone
  fs::path report;  // folder of the page
  std::string title;

  explicit RunPlaces(const RunReportRequest& request)
      : run{run_folder_of(fs::absolute(request.run).lexically_normal() / "")} {
    fs::path root = run.root;
    if (!root.has_filename()) root = root.parent_path();
    run.root = root;
    if (root.filename() == "run" && fs::exists(root.parent_path() / "stages.json"))
      out = root.parent_path();
    const fs::path whole = out.empty() ? root : out;
    report = request.out.empty() ? whole / "report" : fs::absolute(request.out).lexically_normal();
    title = whole.filename().string();
  }

  fs::path stages() const { return out / "stages.json"; }
};

/// The model and its held-out frames (those of training where nothing is held out).
struct RenderedRun {
  GaussianModel model;
  Scene scene;
  std::unique_ptr<Backend> backend;
};

RenderedRun load_run(const RunPlaces& places, const RunReportRequest& request) {
  if (!fs::exists(places.run.model()))
    throw InputError("There is no model yet, so that no view can be rendered.");
  GaussianModel model = load_model(places.run.model());
  const std::string path = scene_of_model(places.run.root);
  if (path.empty() || !fs::exists(path))
    throw InputError("The scene of this run is gone, so that no view can be rendered.");
  const SceneLock in_use(path, SceneLock::Use::kRead);
  Scene scene = scaled_scene(
      scene_for(model, path, {.held_out = std::numeric_limits<int64_t>::max()}), model.train_scale);
  return {std::move(model), std::move(scene), request.backend()};
}

std::vector<ReportLink> links(const RunPlaces& places) {
  std::vector<ReportLink> found;
  const auto add = [&](const char* name, const fs::path& file) {
    std::error_code error;
    if (!fs::exists(file, error)) return;
    const int64_t bytes = fs::is_regular_file(file) ? int64_t(fs::file_size(file)) : -1;
    found.push_back({name, html_address(file.lexically_relative(places.report)), bytes});
  };
  if (!places.out.empty()) add("Player", places.out / "player" / "index.html");
  add("Model", places.run.model());
  add("Scores", places.run.metrics());
  add("Log", places.run.log());
  add("Options", places.run.config());
  if (places.out.empty()) return found;
  add("PLY frames", places.out / "frames" / "manifest.json");
  add("Stages", places.stages());
  return found;
}

json sizes_of(const std::vector<ReportLink>& links) {
  json sizes = json::object();
  for (const ReportLink& link : links)
    if (link.bytes >= 0) sizes[link.name] = link.bytes;
  return sizes;
}

}  // namespace

bool is_run(const fs::path& folder) {
  return RunFolder{run_folder_of(folder)}.exists();
}

json write_run_report(const RunReportRequest& request) {
  if (!is_run(request.run))
    throw InputError(
        fmt::format("{}: is no run: it has no config.json; name the output folder of "
                    "`tessera run` or a run folder",
                    request.run.string()));
  const RunPlaces places(request);
  RunRecords records{
      json_if_sound(places.run.config()), json_if_sound(places.run.metrics()), {}, {}};
  if (!places.out.empty()) records.stages = json_if_sound(places.stages());
  if (fs::exists(places.run.log())) records.log = read_text_file(places.run.log());
  RunPage page;
  std::optional<RenderedRun> rendered;
  try {
    rendered = load_run(places, request);
    if (records.metrics.is_null() && !rendered->scene.frames.empty())
      records.metrics = to_json(evaluate(*rendered->backend, rendered->model, rendered->scene,
                                         rendered->scene.frames.front().split, EvaluateOptions{}),
                                rendered->model);
  } catch (const InputError& error) {
    page.image_note = error.what();
  }
  page.title = places.title;
  page.report = run_report(records);
  page.links = links(places);
  make_folder(places.report);
  if (rendered)
    page.images = run_images(*rendered->backend, rendered->model, rendered->scene, page.report,
                             places.report);
  json data = to_json(page.report);
  data["sizes"] = sizes_of(page.links);
  constexpr auto kReplaceInvalid = json::error_handler_t::replace;
  std::vector<std::pair<fs::path, std::string>> files;
  for (auto& [name, svg] : run_charts(page.report))
    files.emplace_back(places.report / (name + ".svg"), std::move(svg));
  files.emplace_back(places.report / "run.json", data.dump(1, ' ', false, kReplaceInvalid) + "\n");
  files.emplace_back(places.report / "index.html", run_page(page));
  write_together(files);
  data["page"] = (places.report / "index.html").string();
  return data;
}

}  // namespace tessera
