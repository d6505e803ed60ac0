// What: the rows of ingest's options, and the words that stand for their values.
// Not: what is done with them.
#include "tools/ingest_arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "ingest/capture_layout.h"
#include "kernels/base/errors.h"
#include "tools/interrupt.h"
#include "tools/terminal.h"

namespace tessera {
namespace {

const std::map<std::string, SyncMethod> kSyncMethods{{"auto", SyncMethod::kAuto},
                                                     {"none", SyncMethod::kNone},
                                                     {"container", SyncMethod::kContainer},
                                                     {"audio", SyncMethod::kAudio},
                                                     {"motion", SyncMethod::kMotion}};

/// The value that `word` stands for. Errors: InputError that lists the words there are.
template <class Value>
Value value_of(const std::map<std::string, Value>& values, const std::string& word,
               const char* option) {
  if (const auto found = values.find(word); found != values.end()) return found->second;
  std::vector<std::string> words;
  for (const auto& [name, value] : values) words.push_back(name);
  throw InputError(
      fmt::format("{} is '{}', expected one of {}", option, word, fmt::join(words, ", ")));
}

void check_positive(const std::optional<double>& value, const char* option) {
  if (value && !(*value > 0))
    throw InputError(fmt::format("{} is {}, expected more than 0", option, *value));
}

/// What --poses means depends on what is there: a COLMAP model is read, else poses are estimated.
void resolve_poses(const std::string& poses, const std::filesystem::path& capture,
                   IngestOptions& options) {
  options.poses.source = poses;
  if (poses.empty() || poses == "colmap" || poses == "n3dv") return;
  if (!std::filesystem::exists(poses))
    throw InputError(fmt::format(
        "--poses {}: no such file; expected colmap, n3dv (poses_bounds.npy), or a file of cameras",
        poses));
}

void add_choice_of_frames(CLI::App& command, IngestOptions& options) {
  command.add_option("--scale", options.scale, "size of the pictures by the source's, (0, 1]")
      ->capture_default_str();
  command.add_option("--frames", options.frames, "first N instants of each camera");
  command.add_option("--start", options.start, "videos: seconds from the first common moment");
  command.add_option("--duration", options.duration, "videos: seconds to take from there");
  command.add_option("--fps", options.fps, "videos: frames to take per second; default: all");
  command
      .add_option("--cameras", options.cameras, "videos: cameras to take, by name; default: all")
      ->delimiter(',');
  command
      .add_option("--held-out", options.held_out,
                  "cameras (or photos) of the test split, by name; default: the first camera")
      ->delimiter(',');
  command.add_option("--images", options.pictures,
                     "photo sets: folder of the photos, e.g. images_4; default: images");
  command.add_option("--test-every", options.test_every,
                     "photo sets: every Nth photo is for the test; 0: none; default: 8");
}

void add_rig_options(CLI::App& command, IngestArguments& arguments) {
  IngestOptions& options = arguments.options;
  command.add_option("--poses", arguments.poses,
                     "where poses come from: n3dv (poses_bounds.npy), colmap (estimated, or the "
                     "model that is there), or a file of cameras; default: what is there");
  command
      .add_option("--camera-model", options.poses.lens_model,
                  "lens model that colmap estimates; default: SIMPLE_RADIAL")
      ->check(CLI::IsMember(lens_model_names()));
  command.add_option("--intrinsics", arguments.intrinsics,
                     "shared (by cameras of one picture size) or per-camera");
  command
      .add_option("--sync", arguments.sync,
                  "how the cameras' clocks are aligned: auto, none, container, audio, motion")
      ->capture_default_str();
  command.add_option("--offsets", options.sync.offsets,
                     "file of clock offsets, seconds by camera; wins over --sync");
  command.add_flag("--strict", options.strict,
                   "stop where a camera or picture cannot be used, instead of leaving it out");
}

}  // namespace

void add_ingest_options(CLI::App& command, IngestArguments& arguments) {
  add_choice_of_frames(command, arguments.options);
  add_rig_options(command, arguments);
}

IngestOptions resolve_ingest(const IngestArguments& arguments,
                             const std::filesystem::path& capture) {
  IngestOptions options = arguments.options;
  if (options.frames && *options.frames < 1)
    throw InputError(fmt::format("--frames is {}, expected 1 or more", *options.frames));
  check_positive(options.duration, "--duration");
  check_positive(options.fps, "--fps");
  options.sync.method = value_of(kSyncMethods, arguments.sync, "--sync");
  options.poses.intrinsics_per_camera = value_of<bool>(
      {{"shared", false}, {"per-camera", true}}, arguments.intrinsics, "--intrinsics");
  options.poses.strict = options.strict;
  resolve_poses(arguments.poses, capture, options);
  return options;
}
}  // namespace tessera
