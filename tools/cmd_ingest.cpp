// What: `tessera ingest`: a capture → prepared scene.
// Not: the readers (ingest).
#include <fmt/format.h>

#include "ingest/capture_layout.h"
#include "ingest/ingest.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "tools/command.h"
#include "tools/ingest_batch.h"
#include "tools/interrupt.h"
#include "tools/terminal.h"

namespace tessera {
namespace {

struct IngestRequest {
  IngestOptions options;
  std::string capture, out, poses, cloud;
  std::string capture, out, poses, exposure = "none";
  int64_t frames = 0;  // 0: all
  int threads = 0;
  bool batch = false, json = false;
};

std::optional<CloudDensity> cloud_density(const std::string& name) {
  if (name.empty()) return std::nullopt;
  for (const auto& [known, density] : {std::pair{"none", CloudDensity::kNone},
                                       {"sparse", CloudDensity::kSparse},
                                       {"dense", CloudDensity::kDense}})
    if (name == known) return density;
  throw InputError(fmt::format("ingest: --cloud is '{}', expected none, sparse or dense", name));
}

/// Checks the request; `--poses` may decide the layout.
void check_request(IngestRequest& request) {
  if (!(request.options.scale > 0 && request.options.scale <= 1))
    throw InputError(fmt::format("ingest: --scale is {}, expected a value above 0 and up to 1",
                                 request.options.scale));
  if (request.frames < 0)
    throw InputError(fmt::format("ingest: --frames is {}, expected 1 or more", request.frames));
  if (request.exposure != "fit" && request.exposure != "none")
    throw InputError(
        fmt::format("ingest: --exposure is '{}', expected fit or none", request.exposure));
  request.options.fit_exposure = request.exposure == "fit";
  if (request.poses.empty()) return;
  if (request.poses == "colmap") {
    request.options.layout = CaptureLayout::kColmap;
    return;
  }
  if (request.poses == "llff") {
    request.options.layout = CaptureLayout::kLlff;
    return;
  }
  if (request.poses != "n3dv")
    throw InputError(
        fmt::format("ingest: --poses '{}' is not in this version; there are n3dv and llff "
                    "(poses_bounds.npy beside videos, beside photos) and colmap (sparse/0)",
                    request.poses));
  if (request.batch) {
    request.options.layout = CaptureLayout::kN3dv;  // its reader says where it is not
    return;
  }
  if (detect_layout(request.capture) != CaptureLayout::kN3dv)
    throw InputError(
        fmt::format("{}: has no videos with a poses_bounds.npy, which --poses n3dv "
                    "reads; add the file or leave --poses out",
                    request.capture));
}

int ingest_all(const IngestRequest& request) {
  const BatchResult result = ingest_batch(request.capture, request.out, request.options);
  print_result(request.json, batch_json(result, request.out), batch_table(result));
  if (result.interrupted) {
    say("interrupted; run the same command again to go on");
    return kExitInterrupted;
  }
  return result.count(BatchOutcome::kFailed) == 0 ? kExitDone : kExitFailed;
}

int ingest_one(const IngestRequest& request) {
  IngestReport report;
  {
    ProgressBar bar("ingest");
    report = ingest_capture(request.capture, request.out, request.options,
                            [&](std::string_view what, int64_t done, int64_t total) {
                              stop_if_interrupted();
                              bar.update(done, total, what);
                            });
  }
  for (const std::string& warning : report.warnings) warn(warning);
  print_result(request.json,
               {{"out", request.out},
                {"layout", layout_name(report.layout)},
                {"cameras", report.cameras},
                {"frames", report.frames},
                {"points", report.points},
                {"warnings", report.warnings}},
               fmt::format("{}: {} pictures of {} camera{}, {} points", request.out, report.frames,
                           report.cameras, report.cameras == 1 ? "" : "s", report.points));
  return kExitDone;
}

int ingest(IngestRequest request) {
  request.batch = request.batch || is_folder_of_captures(request.capture);
  check_request(request);
  if (request.frames > 0) request.options.frames = request.frames;
  request.options.cloud = cloud_density(request.cloud);
  set_thread_count(request.threads);
  return request.batch ? ingest_all(request) : ingest_one(request);
}

}  // namespace

void add_ingest_command(CLI::App& app, Work& work) {
  CLI::App* command = app.add_subcommand("ingest", "turn a capture into a prepared scene");
  command->option_defaults()->always_capture_default();
  const auto request = std::make_shared<IngestRequest>();
  command->add_option("capture", request->capture, "folder of the capture, or of captures")
      ->required();
  command
      ->add_option("-o,--out", request->out,
                   "prepared scene to write; for a folder of captures, the folder of their scenes")
      ->required();
  command->add_option("--scale", request->options.scale, "size of the pictures by the source's");
  command->add_option("--frames", request->frames, "first N instants of each camera; 0: all");
  command
      ->add_option("--held-out", request->options.held_out,
                   "cameras (or photos) of the test split, by name; default: the first")
      ->delimiter(',');
  command->add_flag("--static", request->options.allow_static,
                    "accept times that are all equal as one moment");
  command->add_flag("--keep-world", request->options.keep_world,
                    "leave the poses' world as it is; default: up, centre and scale are normalised "
                    "where the world is arbitrary (all but transforms)");
  command->add_flag("--batch", request->batch,
                    "prepare every subfolder, also where the folder is a capture itself");
  command->add_option(
      "--poses", request->poses,
      "where poses come from: n3dv (videos), llff (photos), or colmap, also where there "
      "are several");
  command->add_flag("--strict", request->options.strict,
                    "missing or unreadable pictures, and photos without a pose, are errors");
  command->add_option("--images", request->options.pictures,
                      "photo sets: folder of the photos, e.g. images_4; default: images");
  command->add_option("--test-every", request->options.test_every,
                      "COLMAP photo sets: every Nth photo is for the test; 0: none; default: 8");
  command->add_option("--cloud", request->cloud,
                      "initial points: none, sparse (the capture's), dense (and a plane sweep); "
                      "default: dense where three training cameras share moments");
  command->add_option("--cloud-points", request->options.cloud_points,
                      "most points that the plane sweep finds");
  command->add_option("--masks", request->options.masks,
                      "folder of masks named as the pictures or cameras; black is ignored");
  command->add_flag("--invert-masks", request->options.invert_masks, "white is ignored, not black");
  command->add_option("--exposure", request->exposure,
                      "fit: divide each training camera's pictures by its gains; none");
  command->add_option("--threads", request->threads, "CPU threads; 0: all");
  command->add_flag("--json", request->json,
                    "print one JSON object; for a folder of captures, an array");
  command->callback([&work, request] { work = [request] { return ingest(*request); }; });
}

}  // namespace tessera
