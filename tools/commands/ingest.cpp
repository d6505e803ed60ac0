// `tessera ingest` prepares a scene from a capture.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "ingest/camera_table_text.h"
#include "ingest/ingest.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/counted.h"
#include "kernels/base/parallel.h"
#include "tools/cli/command.h"
#include "tools/cli/ingest_arguments.h"
#include "tools/cli/output_place.h"
#include "tools/cli/terminal.h"

namespace tessera {
namespace {

struct IngestRequest {
  IngestArguments arguments;
  std::string capture, out;
  int threads = 0;
  bool overwrite = false, json = false;
};

int ingest(const IngestRequest& request) {
  set_thread_count(request.threads);
  const IngestOptions options = resolve_ingest(request.arguments);
  require_one_capture(request.capture, options);
  check_output_apart(request.out, request.capture);
  check_may_replace(request.out, "a prepared scene", is_prepared_scene(request.out),
                    request.overwrite);
  const IngestReport report = ingest_with_progress(request.capture, request.out, options, "auto");
  print_result(
      request.json,
      {{"out", request.out},
       {"layout", layout_name(report.layout)},
       {"cameras", report.cameras},
       {"frames", report.frames},
       {"points", report.points},
       {"test_views", report.test_views},
       {"notes", report.notes},
       {"camera_table", camera_table_json(report.camera_table)},
       {"warnings", report.warnings}},
      fmt::format("{}: {} of {}, {} points; {}", request.out, counted(report.frames, "image"),
                  counted(report.cameras, "camera"), report.points, report.scored));
  return kExitDone;
}

}  // namespace

void add_ingest_command(CLI::App& app, Work& work) {
  CLI::App* command =
      app.add_subcommand("ingest", "prepare a capture: poses, clocks, images, initial points");
  const auto request = std::make_shared<IngestRequest>();
  command->add_option("capture", request->capture, "folder of the capture")->required();
  command->add_option("-o,--out", request->out, "prepared scene to write")->required();
  add_ingest_options(*command, request->arguments);
  command->add_flag("--static", request->arguments.options.allow_static,
                    "accept times that are all equal as one timestep");
  command->add_flag("--overwrite", request->overwrite,
                    "replace a prepared scene that is there and that no program has in use");
  command->add_option("--threads", request->threads, "CPU threads; 0: all");
  command->add_flag("--json", request->json, "print one JSON object");
  command->callback([&work, request] { work = [request] { return ingest(*request); }; });
}

}  // namespace tessera
