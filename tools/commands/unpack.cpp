// `tessera unpack` writes a prepared scene, a window of it, or what stands still in it, with image
// files.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "ingest/derived/static_scene.h"
#include "ingest/derived/unpacked_scene.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/parallel.h"
#include "tools/cli/command.h"
#include "tools/cli/output_place.h"
#include "tools/cli/terminal.h"
#include "tools/session/locks.h"

namespace tessera {
namespace {

struct UnpackRequest {
  std::string scene, out, window;
  int threads = 0;
  bool still = false, overwrite = false, json = false;
};

int unpack_still(const UnpackRequest& request) {
  if (!request.window.empty())
    throw InputError("--static: is of the whole clip; leave out --window");
  ProgressBar bar("unpack");
  const StaticSceneReport report =
      write_static_scene(request.scene, request.out, [&](int64_t done, int64_t total) {
        stop_if_interrupted();
        bar.update(done, total, "cameras");
      });
  bar.clear();
  for (const std::string& warning : report.warnings) warn(warning);
  print_result(request.json,
               {{"out", request.out},
                {"frames", report.cameras},
                {"shared", report.shared},
                {"warnings", report.warnings}},
               fmt::format("{}: {} images; {:.0f} % of their pixels look the same all along",
                           request.out, report.cameras, 100 * report.shared));
  return kExitDone;
}

int unpack(const UnpackRequest& request) {
  set_thread_count(request.threads);
  std::optional<Window> window;
  if (!request.window.empty()) window = window_of_text(request.window, "--window");
  check_output_apart(request.out, request.scene);
  check_may_replace(request.out, "a prepared scene", is_prepared_scene(request.out),
                    request.overwrite);
  const SceneLock in_use(request.scene, SceneLock::Use::kRead);
  const SceneLock replaced(request.out, SceneLock::Use::kReplace);
  if (request.still) return unpack_still(request);
  ProgressBar bar("unpack");
  const int64_t frames =
      unpack_scene(request.scene, window, request.out, [&](int64_t done, int64_t total) {
        stop_if_interrupted();
        bar.update(done, total, "frames");
      });
  bar.clear();
  print_result(request.json, {{"out", request.out}, {"frames", frames}},
               fmt::format("{}: {} images", request.out, frames));
  return kExitDone;
}

}  // namespace

void add_unpack_command(CLI::App& app, Work& work) {
  CLI::App* command = app.add_subcommand(
      "unpack", "write a prepared scene, a window or the background of it, as images");
  const auto request = std::make_shared<UnpackRequest>();
  command->add_option("scene", request->scene, "prepared scene")->required();
  command->add_option("-o,--out", request->out, "prepared scene to write")->required();
  command->add_option("--window", request->window,
                      "I/N: the I-th of N equal parts of the clip, with 8 timesteps beyond both "
                      "ends; default: all of it");
  command->add_flag("--static", request->still,
                    "what stands still in the whole clip, as a scene of one timestep");
  command->add_flag("--overwrite", request->overwrite,
                    "replace a prepared scene that is there and that no program has in use");
  command->add_option("--threads", request->threads, "CPU threads; 0: all");
  command->add_flag("--json", request->json, "print one JSON object");
  command->callback([&work, request] { work = [request] { return unpack(*request); }; });
}

}  // namespace tessera
