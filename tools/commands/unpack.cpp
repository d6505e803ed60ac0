// `tessera unpack` writes a prepared scene, or a window of it, with an image file for each frame.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "ingest/prepared/transforms_json.h"
#include "ingest/prepared/unpacked_scene.h"
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
  bool overwrite = false, json = false;
};

int unpack(const UnpackRequest& request) {
  set_thread_count(request.threads);
  std::optional<Window> window;
  if (!request.window.empty()) window = window_of_text(request.window, "--window");
  check_output_apart(request.out, request.scene);
  check_may_replace(request.out, "a prepared scene", is_prepared_scene(request.out),
                    request.overwrite);
  const SceneLock in_use(request.scene, SceneLock::Use::kRead);
  const SceneLock replaced(request.out, SceneLock::Use::kReplace);
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
      "unpack", "write a prepared scene, or a window of it, with an image for each frame");
  const auto request = std::make_shared<UnpackRequest>();
  command->add_option("scene", request->scene, "prepared scene")->required();
  command->add_option("-o,--out", request->out, "prepared scene to write")->required();
  command->add_option("--window", request->window,
                      "I/N: the I-th of N equal parts of the clip, with 8 timesteps beyond both "
                      "ends; default: all of it");
  command->add_flag("--overwrite", request->overwrite,
                    "replace a prepared scene that is there and that no program has in use");
  command->add_option("--threads", request->threads, "CPU threads; 0: all");
  command->add_flag("--json", request->json, "print one JSON object");
  command->callback([&work, request] { work = [request] { return unpack(*request); }; });
}

}  // namespace tessera
