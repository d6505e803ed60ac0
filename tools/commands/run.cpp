// `tessera run`: the options and checks of ingest, training, evaluation, export and player in one
// folder. run_stages.h runs them.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "ingest/files/folders.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/prepared/scene_reader.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/command.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/output_place.h"
#include "tools/cli/terminal.h"
#include "tools/cli/training_terminal.h"
#include "tools/run/run_stages.h"
#include "tools/run/run_summary.h"
#include "tools/session/model_scene.h"
#include "tools/view/view_server.h"
#include "tools/windows/window_choice.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// A run without initial points makes none in its training either, unless --sweep or a file of
/// options tells it to.
void apply_cloud_to_training(RunRequest& request) {
  const bool makes_none = resolve_ingest(request.ingest).cloud == CloudDensity::kNone;
  if (makes_none && request.training.config.empty())
    request.training.given.try_emplace("sweep", "false");
}

/// The results of a run are its own. Errors: InputError.
void check_outside_of_runs(const fs::path& out) {
  if (is_run_output(out)) return;
  const fs::path whole = fs::absolute(out).lexically_normal();
  for (fs::path above = whole.parent_path(); above != above.parent_path();
       above = above.parent_path())
    if (is_run_output(above))
      throw InputError(fmt::format(
          "{}: lies in {}, the output of another run; choose a folder beside it with -o",
          out.string(), above.string()));
}

/// What can be refused before anything is written, and not only after hours.
void check_request(const RunRequest& request) {
  const fs::path& capture = request.capture;
  const IngestOptions options = resolve_ingest(request.ingest);
  require_folder(capture);
  require_one_capture(capture, options);
  check_output_apart(request.out, capture);
  check_outside_of_runs(request.out);
  if (!opens_as_scene(capture)) layout_of(capture, options);
  parse_windows(request.windows);
  check_gpus(request.gpus, request.training.backend);
  is_cuda_chosen(request.training.backend);
}

}  // namespace

void add_run_command(CLI::App& app, Work& work) {
  const auto request = std::make_shared<RunRequest>();
  CLI::App& command = *app.add_subcommand(
      "run", "reconstruct a capture: ingest, train, evaluate, export, player; repeat it to resume");
  command.add_option("capture", request->capture, "folder of videos or images")->required();
  command.add_option("-o,--out", request->out, "output folder")->required();
  request->ingest.options.frames_as = FramesAs::kAuto;
  add_ingest_options(command, request->ingest);
  command
      .add_option("--export-frames", request->export_frames,
                  "number of PLY frames to write to OUT/frames, evenly from the first timestep to "
                  "the last; 0 or left out: none")
      ->check(CLI::NonNegativeNumber);
  command
      .add_option("--windows", request->windows,
                  "auto, none or a length as 5s: a long clip is trained window by window; auto: "
                  "where it is longer than 20 s or its images do not fit into the memory")
      ->capture_default_str();
  add_gpus_option(command, request->gpus);
  command.add_option("--title", request->title, "title of the player's page");
  command.add_option("--description", request->description,
                     "description of the player's page, for sites where its address is posted");
  command.add_flag("--overwrite", request->overwrite,
                   "what is there of another request becomes OUT.1; the run starts anew");
  add_view_options(command, request->view);
  command.add_flag("--json", request->json_output, "print one JSON object");
  request->training.evaluate_every = kNeverEvaluate;  // a stage of its own scores the model
  add_train_options(command, request->training);
  command.callback([request, &work] {
    work = [request] {
      set_thread_count(request->training.threads);
      if (request->view.view) require_view_server();
      check_request(*request);
      apply_cloud_to_training(*request);
      std::unique_ptr<ViewChild> view;
      const std::optional<nlohmann::json> result = run_stages(*request, view);
      const int code = stop_code();  // a signal that ends the view later does not count
      if (!result) {
        report_error("tessera: interrupted; run the same command again to resume");
        if (view) view->serve("where the training has stopped");
        return code;
      }
      print_result(request->json_output, *result, run_summary(*result, score_detail()));
      if (view) view->serve("the result");
      return int(kExitDone);
    };
  });
}

}  // namespace tessera
