// Writes the plan, runs it, collects the results and writes them. The plan is written first, so
// that --plot works at any time.
#include "tools/bench/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "tools/bench/report.h"
#include "tools/bench/runner.h"
#include "tools/bench/scene_chart.h"
#include "tools/bench/size_chart.h"
#include "tools/bench/table_text.h"
#include "tools/cli/output_place.h"
#include "tools/cli/terminal.h"
#include "tools/session/version.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Of the files of this mode: "chart", "curve", "table_mcmc".
std::string stem_of(const SweepRequest& request) {
  switch (request.mode) {
    case BenchMode::kChart:
      return "chart";
    case BenchMode::kCurve:
      return "curve";
    case BenchMode::kSizes:
      return "sizes";
    default:
      return "table_" + bench_table(request.table).name;
  }
}

BenchRunOptions run_options(const SweepRequest& request) {
  BenchRunOptions options;
  options.root = request.out;
  options.backend = request.axes.training.backend;
  options.checkpoint_every = request.axes.training.checkpoint_every;
  if (request.shard.empty()) return options;
  int64_t index = 0;
  int end = 0;
  const int read = std::sscanf(request.shard.c_str(), "%ld/%ld%n", &index, &options.shards, &end);
  if (read != 2 || size_t(end) != request.shard.size() || index < 1 || index > options.shards)
    throw InputError(
        fmt::format("--shard {}: expected i/n with i from 1 to n, e.g. 1/4", request.shard));
  options.shard = index - 1;
  return options;
}

BenchPlan plan_of(const SweepRequest& request, const std::vector<BenchScene>& scenes) {
  switch (request.mode) {
    case BenchMode::kChart:
      return plan_chart(request.axes, scenes, request.budgets);
    case BenchMode::kCurve:
      return plan_curve(request.axes, scenes, request.score_at);
    case BenchMode::kSizes:
      return plan_sizes(request.axes, scenes);
    default:
      return plan_table(request.axes, scenes, bench_table(request.table));
  }
}

/// The runs that hang on the `records` of those before.
std::vector<BenchRun> runs_after(const SweepRequest& request, const std::vector<BenchScene>& scenes,
                                 const json& records) {
  if (request.mode == BenchMode::kSizes)
    return plan_budgets(request.axes, scenes, request.shares, records).runs;
  if (request.mode == BenchMode::kTable)
    return plan_counted_rows(request.axes, scenes, bench_table(request.table), records).runs;
  return {};
}

/// What stays of an output file between calls: which runs there are, what was left out.
struct Sweep {
  json runs = json::array();
  std::vector<std::string> skipped;
  json published = json::array();
};

void write_report(const SweepRequest& request, const json& report) {
  write_text_file(request.out / (stem_of(request) + ".json"), report.dump(2));
}

json report_of(const SweepRequest& request, const Sweep& done) {
  json runs = done.runs;
  for (json& run : runs) run.erase("options");  // in its result.json
  json report = {{"tessera", kVersionText},
                 {"kind", stem_of(request)},
                 {"cells", runs},
                 {"skipped", done.skipped}};
  report["scenes"] = bench_points(request.mode == BenchMode::kCurve ? curve_runs(runs) : runs);
  if (request.mode == BenchMode::kTable) {
    add_published(report["scenes"], bench_table(request.table));
    return report;
  }
  if (request.mode == BenchMode::kSizes) return report;
  report["published"] = done.published;
  if (request.mode == BenchMode::kCurve) return report;
  mark_pareto_front(report["scenes"]);
  report["knee"] =
      "the frontier's point farthest above the line from its fastest to its best point, with "
      "log(seconds) and PSNR scaled to [0, 1] between these two";
  return report;
}

std::string text_of(const SweepRequest& request, const json& report) {
  if (request.mode == BenchMode::kTable) {
    const BenchTable& table = bench_table(request.table);
    std::string text = fmt::format("# {}: {}\n\n{}", table.name, table.doc,
                                   tables_text(report["scenes"], table.columns));
    for (const json& line : report["skipped"])
      text += fmt::format("\n\n{}", line.get<std::string>());
    return text;
  }
  if (request.mode == BenchMode::kCurve)
    return tables_text(report["scenes"], {"psnr", "ssim", "seconds", "num_gaussians"});
  if (request.mode == BenchMode::kSizes)
    return tables_text(report["scenes"], {"num_gaussians", "num_static", "num_dynamic",
                                          "shipped_bytes", "psnr", "seconds"});
  return tables_text(report["scenes"],
                     {"psnr", "ssim", "seconds", "num_gaussians", "bytes", "fps"});
}

/// One image of all scenes.
void draw_sizes(const SweepRequest& request, const json& report) {
  if (!has_sizes(report["scenes"])) return warn("no size to draw yet");
  write_text_file(request.out / (stem_of(request) + ".svg"), sizes_svg(report["scenes"]));
}

void draw(const SweepRequest& request, const json& report) {
  if (request.mode == BenchMode::kSizes) return draw_sizes(request, report);
  for (const json& scene : report["scenes"]) {
    const std::string name = scene["scene"];
    if (!can_be_drawn(scene)) {
      warn(fmt::format("{}: nothing to draw yet", name));
      continue;
    }
    ImageRequest image;
    image.kind = request.mode == BenchMode::kCurve ? BenchImage::kCurve : BenchImage::kChart;
    image.emphasised = TrainArguments{}.preset;
    image.published = report["published"];
    write_text_file(request.out / fmt::format("{}_{}.svg", stem_of(request), name),
                    scene_svg(scene, image));
  }
}

/// The outputs of what is done, on disk and stdout; the exit code.
int finish(const SweepRequest& request, const Sweep& done) {
  const json report = report_of(request, done);
  write_report(request, report);
  const std::string stem = stem_of(request), text = text_of(request, report);
  write_text_file(request.out / (stem + ".csv"), csv_of(report["scenes"]));
  if (request.mode == BenchMode::kTable || request.mode == BenchMode::kSizes)
    write_text_file(request.out / (stem + ".md"), text + "\n");
  if (request.mode != BenchMode::kTable) draw(request, report);
  const std::vector<std::string> devices = devices_of(done.runs);
  if (devices.size() > 1)
    warn(fmt::format("runs were on several devices, whose seconds do not compare: {}",
                     fmt::join(devices, "; ")));
  int64_t failed = 0, missing = 0;
  for (const json& run : done.runs) {
    missing += run["status"] == "missing";
    if (run["status"] != "failed") continue;
    ++failed;
    report_error(
        fmt::format("failed: {}: {}", run["folder"].get<std::string>(), run.value("error", "")));
  }
  if (missing > 0)
    say(fmt::format("{} of {} runs are not done yet; the same command runs them", missing,
                    done.runs.size()));
  print_result(request.json, report, text);
  return failed > 0 ? kExitFailed : kExitDone;
}

/// Writes what is done and which runs are next, so that --plot includes them.
void announce(const SweepRequest& request, Sweep done, const std::vector<BenchRun>& next) {
  for (const BenchRun& run : next)
    done.runs.push_back(recorded_run(request.out, describe_run(run)));
  write_report(request, report_of(request, done));
}

Sweep run(const SweepRequest& request) {
  const BenchRunOptions options = run_options(request);
  Sweep done;
  if (!request.published.empty()) done.published = read_published(request.published);
  const std::vector<BenchScene> scenes = open_bench_scenes(request.scenes);
  for (const BenchScene& scene : scenes) check_output_apart(request.out, scene.path);
  const BenchPlan plan = plan_of(request, scenes);
  done.skipped = plan.skipped;
  for (const std::string& line : plan.skipped) say(line);
  make_folder(request.out);
  announce(request, done, plan.runs);
  done.runs = complete_runs(options, plan.runs);
  const std::vector<BenchRun> more = runs_after(request, scenes, done.runs);
  announce(request, done, more);
  for (const json& record : complete_runs(options, more)) done.runs.push_back(record);
  return done;
}

/// The runs of the last call, as they are by now.
Sweep gathered(const SweepRequest& request) {
  const fs::path file = request.out / (stem_of(request) + ".json");
  if (!fs::exists(file))
    throw InputError(
        fmt::format("{}: no such file to plot from; run the same without --plot", file.string()));
  const json report = read_json(file);
  Sweep done;
  if (!report.is_object() || !report.contains("cells"))
    throw InputError(fmt::format("{}: has no runs; run the same without --plot", file.string()));
  for (const json& run : report["cells"]) done.runs.push_back(recorded_run(request.out, run));
  done.skipped = report.value("skipped", std::vector<std::string>());
  done.published = request.published.empty() ? report.value("published", json::array())
                                             : read_published(request.published);
  return done;
}

}  // namespace

int sweep(const SweepRequest& request) {
  set_thread_count(request.axes.training.threads);
  return finish(request, request.plot_only ? gathered(request) : run(request));
}

}  // namespace tessera
