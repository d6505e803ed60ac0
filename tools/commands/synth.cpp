// `tessera synth` makes a synthetic capture with ground truth (tools/synth).
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "kernels/base/counted.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/options/nearest_name.h"
#include "tools/cli/command.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/output_place.h"
#include "tools/cli/terminal.h"
#include "tools/session/locks.h"
#include "tools/synth/synth.h"

namespace tessera {
namespace {

struct SynthRequest {
  SynthOptions options;
  std::string scene, layout = "n3dv", fps = "24", out;
  std::vector<std::string> shifts, readouts;
  int threads = 0;
  bool list = false, overwrite = false, json = false;
};

template <class Rows>
std::vector<std::string> names_of(const Rows& rows) {
  std::vector<std::string> names;
  for (const auto& row : rows) names.emplace_back(row.name);
  return names;
}

[[noreturn]] void unknown(const char* what, const std::string& typed,
                          const std::vector<std::string>& names) {
  throw InputError(fmt::format("synth: unknown {} '{}'{}", what, typed, known_names(typed, names)));
}

/// "cam03=1.5" → the value of camera 3.
void parse_frames(const char* option, const std::string& text, std::vector<double>& values) {
  constexpr std::string_view kPrefix = "cam";
  const char* const end = text.data() + text.size();
  size_t camera = 0;
  double frames = 0;
  auto parsed = std::from_chars(text.data() + std::min(kPrefix.size(), text.size()), end, camera);
  const bool named = text.starts_with(kPrefix) && parsed.ec == std::errc() && camera < 100 &&
                     parsed.ptr != end && *parsed.ptr == '=';
  if (named) parsed = std::from_chars(parsed.ptr + 1, end, frames);
  if (!named || parsed.ec != std::errc() || parsed.ptr != end)
    throw InputError(
        fmt::format("synth: {} is '{}'; give a camera and frames like cam03=1.5", option, text));
  values.resize(std::max(values.size(), camera + 1));
  values[camera] = frames;
}

int list_scenes(bool as_json) {
  nlohmann::json lists;
  std::string text;
  const auto add = [&](const char* what, const auto& rows) {
    text += fmt::format("{}{}:", text.empty() ? "" : "\n", what);
    for (const auto& row : rows) {
      lists[what].push_back({{"name", row.name}, {"doc", row.doc}});
      text += fmt::format("\n  {:<12} {}", row.name, row.doc);
    }
  };
  add("scenes", synth_scenes());
  add("layouts", synth_layouts());
  print_result(as_json, lists, text);
  return kExitDone;
}

int synth(SynthRequest request) {
  if (request.list) return list_scenes(request.json);
  if (request.scene.empty()) throw InputError("synth: name a scene; see tessera synth --list");
  if (request.out.empty()) throw InputError("synth: name the output folder with -o DIR");
  const auto scene = find_synth_scene(request.scene);
  if (!scene) unknown("scene", request.scene, names_of(synth_scenes()));
  const auto layout = find_synth_layout(request.layout);
  if (!layout) unknown("layout", request.layout, names_of(synth_layouts()));
  request.options.scene = *scene;
  request.options.layout = *layout;
  request.options.fps = parse_frame_rate("synth", request.fps);
  for (const std::string& shift : request.shifts)
    parse_frames("--shift", shift, request.options.shifts);
  for (const std::string& readout : request.readouts)
    parse_frames("--readout", readout, request.options.readouts);
  set_thread_count(request.threads);
  const std::filesystem::path out = request.out;
  check_may_replace(out, "a made capture", is_made_capture(out), request.overwrite);
  const SceneLock replaced(out, SceneLock::Use::kReplace);

  SynthReport report;
  {
    ProgressBar bar("synth");
    report = make_capture(request.options, request.out,
                          [&](std::string_view what, int64_t done, int64_t total) {
                            stop_if_interrupted();
                            bar.update(done, total, what);
                          });
  }
  print_result(
      request.json,
      {{"out", request.out},
       {"scene", request.scene},
       {"layout", request.layout},
       {"cameras", report.cameras},
       {"images", report.images},
       {"points", report.points}},
      fmt::format("{}: {}, {}, {} points of truth", request.out, counted(report.cameras, "camera"),
                  counted(report.images, "image"), report.points));
  return kExitDone;
}

}  // namespace

void add_synth_command(CLI::App& app, Work& work) {
  CLI::App* command =
      app.add_subcommand("synth", "render a synthetic capture with exact ground truth");
  command->option_defaults()->always_capture_default();
  const auto request = std::make_shared<SynthRequest>();
  SynthOptions& options = request->options;
  command->add_option("name", request->scene, "scene, one of --list");
  command->add_option("-o,--out", request->out, "folder to make");
  command->add_flag("--list", request->list, "list scenes and layouts");
  command->add_option("--layout", request->layout, "dnerf, n3dv or videos");
  command->add_option("--cameras", options.cameras, "cameras (n3dv, videos)");
  command->add_option("--frames", options.frames, "instants; dnerf: training views");
  command->add_option("--repeat", options.repeat,
                      "n3dv, videos: instants after which all moves back, and then again; 0: as "
                      "many as the clip has");
  command->add_option("--held-out-frames", options.held_out_frames,
                      "dnerf: views in each of val and test; 0: a fifth of --frames");
  command->add_option("--width", options.width, "pixels; 0: the scene's own");
  command->add_option("--height", options.height, "pixels; 0: the scene's own");
  command->add_option("--fps", request->fps, "frames a second, N or N/D");
  command
      ->add_option("--shift", request->shifts,
                   "camNN=X[,...]: that camera films X frames later than its stamps say")
      ->delimiter(',');
  command
      ->add_option("--readout", request->readouts,
                   "camNN=X[,...]: that camera has a rolling shutter: its bottom row is exposed X "
                   "frames after the top one, or before")
      ->delimiter(',');
  command->add_option("--seed", options.seed, "of textures, colours and small offsets");
  command->add_option("--supersampling", options.supersampling, "N x N rays a pixel");
  command->add_option("--specular", options.specular, "strength of highlights, 0 to 1");
  command->add_option("--video-quality", options.video_quality, "x264 crf, 0 (lossless) to 51");
  command->add_option("--noise", options.noise_sigma, "sigma of each channel, levels of 255");
  command->add_option("--exposure-wobble", options.exposure_wobble,
                      "largest relative change of a training frame's gain: 0.01 is 1 %");
  command->add_option("--light-step", options.light_step,
                      "n3dv, videos: factor of the light from the middle of the clip on, 0.25 to "
                      "4; 1: no change");
  command->add_flag("--camera-gains", options.camera_gains,
                    "n3dv, videos: gains of red, green and blue from 0.8 to 1.2 for every camera "
                    "but cam00");
  command->add_option("--moving-share", options.moving_share,
                      "patch: share of the image in which something moves, 0.005 to 0.3; 0: 0.05");
  command->add_option("--points", options.points, "static surface points of truth");
  command->add_flag("--overwrite", request->overwrite, "replace a made capture that is there");
  command->add_option("--threads", request->threads, "CPU threads; 0: all");
  command->add_flag("--json", request->json, "print one JSON object");
  command->callback([&work, request] { work = [request] { return synth(*request); }; });
}

}  // namespace tessera
