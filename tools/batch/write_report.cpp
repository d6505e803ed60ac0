// Collects the data, renders the views and writes the files.
#include "tools/batch/write_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "tools/batch/batch_page.h"
#include "tools/batch/batch_report.h"
#include "tools/batch/held_out_views.h"
#include "tools/bench/report.h"
#include "tools/bench/scene_chart.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr size_t kManyScenes = 100;             // above, one view of each
constexpr size_t kMostPictureBytes = 64 << 20;  // within the page

void draw_charts(const json& report, const fs::path& folder, BatchImages& images) {
  for (const json& scene : report["scenes"]) {
    const std::string name = scene["scene"];
    const std::string svg = scene_svg(scene, {});
    if (svg.empty()) continue;
    write_text_file(folder / fmt::format("chart_{}.svg", name), svg);
    images.charts.emplace_back(name, svg);
  }
}

/// Adds a run's views to those of its scene; the truth is that of the first run with the frame.
/// Returns the bytes of what was added.
size_t add_views(std::vector<ComparedView>& views, const json& run,
                 const std::vector<HeldOutView>& drawn) {
  size_t bytes = 0;
  for (const HeldOutView& one : drawn) {
    bytes += one.drawn.size();
    ComparedView* compared = nullptr;
    for (ComparedView& view : views)
      if (view.frame == one.frame) compared = &view;
    if (compared == nullptr) {
      compared = &views.emplace_back(ComparedView{one.frame, one.truth, {}});
      bytes += one.truth.size();
    }
    compared->renders.push_back({run["preset"], one.drawn, one.psnr});
  }
  return bytes;
}

std::vector<ComparedView>& views_of(BatchImages& images, const std::string& scene) {
  for (auto& [name, views] : images.views)
    if (name == scene) return views;
  return images.views.emplace_back(scene, std::vector<ComparedView>{}).second;
}

/// Of each preset of a scene the first seed that has a score.
void draw_views(const ReportRequest& request, const json& report, BatchImages& images) {
  const std::unique_ptr<Backend> backend = make_backend(request.backend);
  ProgressBar bar("report");
  const int64_t most = report["scenes"].size() > kManyScenes ? 1 : request.images;
  json drawn = json::array();
  int64_t done = 0;
  size_t bytes = 0;
  for (const json& run : report["runs"]) {
    stop_if_interrupted();
    bar.update(++done, int64_t(report["runs"].size()), "views");
    const json which = {run["scene"], run["preset"]};
    if (!run.contains("psnr") || std::find(drawn.begin(), drawn.end(), which) != drawn.end())
      continue;
    drawn.push_back(which);
    if (bytes > kMostPictureBytes) {
      images.notes.push_back(
          fmt::format("Images from {} on are left out, as the page has {} MiB of them; `tessera "
                      "report --pictures 0` makes one without any.",
                      run["scene"].get<std::string>(), bytes >> 20));
      return;
    }
    try {
      const std::vector<HeldOutView> views =
          held_out_views(*backend, request.out / run["folder"].get<std::string>(), most);
      bytes += add_views(views_of(images, run["scene"]), run, views);
    } catch (const InputError& error) {
      images.notes.push_back(error.what());
    }
  }
}

}  // namespace

json write_report(const ReportRequest& request) {
  const json report = batch_report(read_batch(request.out));
  const fs::path folder = request.out / "report";
  make_folder(folder);
  BatchImages images;
  draw_charts(report, folder, images);
  if (request.images > 0) draw_views(request, report, images);
  constexpr auto kReplaceInvalid = json::error_handler_t::replace;
  write_together({{folder / "report.csv", csv_of(report["scenes"])},
                  {folder / "report.json", report.dump(1, ' ', false, kReplaceInvalid) + "\n"},
                  {folder / "index.html", batch_page(report, images)}});
  return report;
}

}  // namespace tessera
