// Defines the ingest options and converts the given words into values.
#include "tools/cli/ingest_arguments.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "ingest/camera_table_text.h"
#include "ingest/files/cache_folder.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/stage_ledger.h"
#include "tools/cli/terminal.h"
#include "tools/session/locks.h"

namespace tessera {
namespace {

template <class Value>
using Words = std::vector<std::pair<const char*, Value>>;

const Words<bool> kIntrinsicsWords{{"per-camera", true}, {"shared", false}};
const Words<PoseSource::Kind> kPoseWords{{"", PoseSource::kFound},
                                         {"colmap", PoseSource::kColmap},
                                         {"llff", PoseSource::kLlff},
                                         {"n3dv", PoseSource::kN3dv}};

template <class Value>
auto find_word(const Words<Value>& words, const std::string& word) {
  return std::find_if(words.begin(), words.end(),
                      [&](const auto& row) { return row.first == word; });
}

/// The value that `word` stands for. Errors: InputError that lists the words there are.
template <class Value>
Value value_of(const Words<Value>& words, const std::string& word, const char* option) {
  if (const auto found = find_word(words, word); found != words.end()) return found->second;
  std::vector<const char*> known;
  for (const auto& [name, value] : words) known.push_back(name);
  throw InputError(
      fmt::format("{} is '{}', expected one of {}", option, word, fmt::join(known, ", ")));
}

template <class Enum>
Enum enum_of(const std::string& word, const char* option) {
  Words<Enum> words;
  for (const char* name : kEnumNames<Enum>) words.emplace_back(name, Enum(words.size()));
  return value_of(words, word, option);
}

/// "16ms", "0.016", "cam01=16ms" each, in seconds by camera.
std::map<std::string, double> readouts_of(const std::vector<std::string>& texts) {
  constexpr double kLongest = 1;
  std::map<std::string, double> readouts;
  for (const std::string& text : texts) {
    const size_t equals = text.rfind('=');
    const size_t first = equals == std::string::npos ? 0 : equals + 1;
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data() + first, end, value);
    const std::string_view unit(parsed.ptr, end);
    if (unit == "ms") value /= 1000;
    if (parsed.ec != std::errc() || !(unit.empty() || unit == "s" || unit == "ms") ||
        !(std::abs(value) <= kLongest))
      throw InputError(fmt::format(
          "--readout is '{}'; give a time up to a second like 16ms, or a camera and a time like "
          "cam01=16ms",
          text));
    readouts[first == 0 ? "" : text.substr(0, equals)] = value;
  }
  return readouts;
}

/// A word, or a file or folder of cameras.
PoseSource pose_source(const std::string& word) {
  const auto found = find_word(kPoseWords, word);
  if (found != kPoseWords.end()) return {found->second, {}};
  return {PoseSource::kCameras, word};
}

std::string text_of(const PoseSource& source) {
  for (const auto& [word, kind] : kPoseWords)
    if (kind == source.kind) return word;
  return source.cameras.string();
}

void add_frame_options(CLI::App& command, IngestArguments& arguments) {
  IngestOptions& options = arguments.options;
  command.add_option(
      "--layout", arguments.layout,
      "how images are read: rig (several cameras that film together), photos (of a static "
      "scene), moving (one camera that moves); default: from their names");
  command
      .add_option("--scale", options.scale,
                  "image size relative to the source, above 0 to 1, or 50%")
      ->capture_default_str();
  command.add_option("--frames", options.frames,
                     "use the first N timesteps of each camera; default: all");
  command.add_option("--start", options.start,
                     "videos: begin so many seconds after the first common timestep");
  command.add_option("--duration", options.duration, "videos: use so many seconds; default: all");
  command.add_option(
      "--fps", options.fps,
      "videos: use so many frames per second; default: all. Image sequences: frame rate of "
      "the numbers; default: 30");
  command
      .add_option("--cameras", options.cameras, "videos: use these cameras, by name; default: all")
      ->delimiter(',');
  command
      .add_option(
          "--held-out", options.held_out,
          "test cameras (or photos), by name, or none; default: the innermost camera of a rig; for "
          "photos see --test-every")
      ->delimiter(',');
  command
      .add_option("--frames-as", arguments.frames_as,
                  "videos of fixed cameras: png (an image a frame), video (frames are decoded "
                  "from the source videos when the scene is loaded, and take no disk), or auto "
                  "(video where the clip is longer than 20 s)")
      ->capture_default_str();
  command.add_option("--images", options.images,
                     "photos: folder of the images, for example images_4; default: images");
  command.add_option(
      "--test-every", options.test_every,
      "photos, one moving camera, transforms files without test frames: every Nth image by "
      "name is a test view; 0: none; default: 8");
}

void add_camera_options(CLI::App& command, IngestArguments& arguments) {
  IngestOptions& options = arguments.options;
  command.add_option(
      "--poses", arguments.poses,
      "source of the poses: n3dv or llff (poses_bounds.npy), colmap (an existing model, else "
      "estimated), or a file or folder of cameras; default: what the folder has");
  command.add_option(
      "--camera-model", options.poses.lens_model,
      "lens model that COLMAP estimates, for example OPENCV; default: the simplest that fits");
  command
      .add_option("--intrinsics", arguments.intrinsics,
                  "estimated intrinsics: shared (by cameras of one image size) or per-camera")
      ->capture_default_str();
  command
      .add_option(
          "--undistort", arguments.undistort,
          "view of images whose lens distortion is removed: valid (cropped until all pixels "
          "are valid), full (up to 120 degrees; blank pixels are masked), or auto (full "
          "where the crop would take more than a tenth)")
      ->capture_default_str();
  command
      .add_option(
          "--sync", arguments.sync,
          "how the clocks of the cameras are aligned: auto, none, container, audio or motion")
      ->capture_default_str();
  command.add_option("--offsets", options.sync.offsets,
                     "file of clock offsets in seconds by camera; replaces --sync");
  command
      .add_option("--readout", arguments.readouts,
                  "videos: time in which a rolling shutter reads an image from its top row to its "
                  "bottom one, for example 16ms, or of single cameras cam01=16ms,cam02=-8ms")
      ->delimiter(',');
  command.add_flag("--strict", options.strict,
                   "treat a missing or unreadable image and a camera without a pose as errors");
}

void add_image_options(CLI::App& command, IngestArguments& arguments) {
  IngestOptions& options = arguments.options;
  command.add_option("--masks", options.masks,
                     "folder of masks, named as the images or cameras; black pixels are ignored");
  command.add_flag("--invert-masks", options.invert_masks,
                   "ignore white pixels instead of black ones");
  command.add_flag("--fit-exposure", options.fit_exposure,
                   "divide each training camera's images by its gains, measured on features");
  command.add_flag("--keep-world", options.keep_world,
                   "leave the poses' world as it is; default: up, centre and scale are normalised "
                   "where the world is arbitrary (all but transforms)");
  command.add_option(
      "--cloud", arguments.cloud,
      "initial points: none, sparse (the capture's, else COLMAP's), dense (and a plane "
      "sweep); "
      "default: dense where three training cameras share timesteps; none where frames stay in "
      "videos, as each training makes its own");
  command
      .add_option("--cloud-points", options.cloud_points,
                  "largest number of points of the plane sweep")
      ->capture_default_str();
}

/// A hash of the current version of a file or folder; null where none is named.
nlohmann::json stamps_of(const std::filesystem::path& path) {
  if (path.empty() || !std::filesystem::exists(path)) return nullptr;
  return key_of(file_stamps(path));
}

}  // namespace

void add_ingest_options(CLI::App& command, IngestArguments& arguments) {
  add_frame_options(command, arguments);
  add_camera_options(command, arguments);
  add_image_options(command, arguments);
}

IngestOptions resolve_ingest(const IngestArguments& arguments) {
  IngestOptions options = arguments.options;
  check_values(options);
  options.sync.method = enum_of<SyncMethod>(arguments.sync, "--sync");
  options.readouts = readouts_of(arguments.readouts);
  options.poses.source = pose_source(arguments.poses);
  options.poses.intrinsics_per_camera =
      value_of(kIntrinsicsWords, arguments.intrinsics, "--intrinsics");
  options.poses.strict = options.strict;
  if (const auto cache = user_cache_folder(); !cache.empty())
    options.poses.cache = cache / "colmap";
  options.frames_as = enum_of<FramesAs>(arguments.frames_as, "--frames-as");
  options.field_of_view = enum_of<FieldOfView>(arguments.undistort, "--undistort");
  if (!arguments.layout.empty())
    options.image_layout = enum_of<ImageLayout>(arguments.layout, "--layout");
  if (!arguments.cloud.empty()) options.cloud = enum_of<CloudDensity>(arguments.cloud, "--cloud");
  return options;
}

void require_one_capture(const std::filesystem::path& folder, const IngestOptions& options) {
  if (!is_folder_of_captures(folder, options.image_layout)) return;
  const bool may_be_rig = find_video_folders(folder).cameras.size() > 1 ||
                          find_image_sequences(folder).cameras.size() > 1;
  throw InputError(fmt::format(
      "{}: is no capture, but holds some ({}); {}name one of them, or all of them to `tessera "
      "batch`",
      folder.string(), listed_names(captures_in(folder, options.image_layout)),
      may_be_rig ? "if they are the cameras of one scene, pass --layout rig; else " : ""));
}

nlohmann::json to_json(const IngestOptions& o) {
  constexpr const char* kDefault = "default";  // which follows from the capture
  nlohmann::json object{{"scale", o.scale},
                        {"frames", o.frames.value_or(0)},
                        {"start", o.start},
                        {"duration", o.duration.value_or(0)},
                        {"fps", o.fps.value_or(0)},
                        {"cameras", o.cameras},
                        {"held_out", o.held_out},
                        {"static", o.allow_static},
                        {"layout", o.layout ? layout_name(*o.layout) : ""},
                        {"image_layout", o.image_layout ? name_of(*o.image_layout) : kDefault},
                        {"images", o.images},
                        {"frames_as", name_of(o.frames_as)},
                        {"undistort", name_of(o.field_of_view)},
                        {"test_every", o.test_every.value_or(-1)},
                        {"poses", text_of(o.poses.source)},
                        {"files of the poses", stamps_of(o.poses.source.cameras)},
                        {"camera_model", o.poses.lens_model},
                        {"intrinsics_per_camera", o.poses.intrinsics_per_camera},
                        {"sync", name_of(o.sync.method)},
                        {"files of the offsets", stamps_of(o.sync.offsets)},
                        {"strict", o.strict},
                        {"files of the masks", stamps_of(o.masks)},
                        {"invert_masks", o.invert_masks},
                        {"fit_exposure", o.fit_exposure},
                        {"keep_world", o.keep_world},
                        {"cloud", o.cloud ? name_of(*o.cloud) : kDefault},
                        {"cloud_points", o.cloud_points}};
  if (!o.readouts.empty()) object["readouts"] = o.readouts;
  return object;
}

IngestReport ingest_with_progress(const std::filesystem::path& capture,
                                  const std::filesystem::path& out, const IngestOptions& options,
                                  const std::string& backend) {
  const SceneLock replaced(out, SceneLock::Use::kReplace);
  ProgressBar bar("ingest");
  IngestOptions checked = options;
  checked.check_cameras = true;
  std::unique_ptr<Backend> device;
  checked.pixel_search = [&] {
    device = make_backend(backend);
    return device->pixel_search();
  };
  const IngestReport report = ingest_capture(
      capture, out, checked, [&](std::string_view what, int64_t done, int64_t total) {
        stop_if_interrupted();
        bar.update(done, total, what);
      });
  bar.clear();
  for (const std::string& note : report.notes) say(note);
  for (const std::string& line : camera_table_lines(report.camera_table)) say(line);
  for (const std::string& warning : report.warnings) warn(warning);
  return report;
}

}  // namespace tessera
