// Sizes and lengths are those that the list of frames states.
#include "tools/windows/window_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

#include "ingest/clocks/windows.h"
#include "ingest/ingest.h"
#include "kernels/base/errors.h"
#include "recon4d/options/forecast.h"
#include "tools/session/clock/time_limit.h"

namespace tessera {
namespace {

constexpr double kWindowSeconds = 5;
constexpr int64_t kLeastTimesteps = 12;  // of a window's core
constexpr double kMemoryShare = 0.5;     // that the images of a training may take

}  // namespace

WindowWish parse_windows(const std::string& text) {
  if (text == "none") return {};
  if (text == "auto") return {WindowWish::Kind::kAuto, 0};
  constexpr std::string_view kAuto = "auto:";
  const bool is_auto = text.starts_with(kAuto);
  double seconds = 0;
  try {
    seconds = parse_duration(is_auto ? text.substr(kAuto.size()) : text);
  } catch (const InputError&) {
    seconds = 0;
  }
  if (!(seconds > 0))
    throw InputError(
        fmt::format("--windows {}: expected auto, none, or the length of a window, e.g. 5s", text));
  return {is_auto ? WindowWish::Kind::kAuto : WindowWish::Kind::kLength, seconds};
}

int64_t timesteps_of(const Scene& scene) {
  int64_t last = -1;
  for (const Frame& frame : scene.frames) last = std::max(last, frame.timestep);
  return last + 1;
}

std::string reason_against_windows(const Scene& scene) {
  if (scene.is_static) return "it has one timestep";
  if (scene.had_alpha) return "its images have alpha, so that no background is shared";
  std::map<std::string, const Camera*> cameras;
  std::map<std::string, int64_t> frames;
  for (const Frame& frame : scene.frames) {
    const Camera*& first = cameras[frame.camera_name];
    if (first == nullptr) first = &frame.camera;
    if (!(*first == frame.camera))
      return fmt::format("camera {} moves, and windows share what fixed cameras see",
                         frame.camera_name);
    if (frame.split == Split::kTrain) ++frames[frame.camera_name];
  }
  if (frames.size() < 2) return "it has one training camera, and windows are for rigs";
  return "";
}

std::string whole_clip_text(const std::string& reason) {
  return fmt::format("windows: the clip is trained as a whole, as {}", reason);
}

WindowChoice choose_windows(const WindowWish& wish, const Scene& scene, int64_t memory) {
  if (wish.kind == WindowWish::Kind::kNone) return {};
  const bool is_asked = wish.kind == WindowWish::Kind::kLength;
  const double seconds = scene.time_axis.duration;
  const ForecastLoad load = forecast_load(scene);
  // a window marks what moves in each of its training frames
  const int64_t bytes = load.image_bytes + load.mask_bytes + load.moving_mask_bytes,
                timesteps = timesteps_of(scene);
  const auto room = int64_t(kMemoryShare * double(memory));
  if (wish.seconds == 0 && seconds <= kLongClip && bytes <= room) return {};
  if (const std::string reason = reason_against_windows(scene); !reason.empty()) {
    if (is_asked)
      throw InputError(fmt::format("--windows: {}: {}; leave the option out", scene.path, reason));
    return {1, whole_clip_text(reason)};
  }
  const double length = wish.seconds > 0 ? wish.seconds : kWindowSeconds;
  auto count = int64_t(std::ceil(seconds / length - 1e-6));
  const int64_t most = std::max<int64_t>(1, timesteps / kLeastTimesteps);
  if (is_asked && count > most)
    throw InputError(fmt::format(
        "--windows: {} windows of {:g} s would have less than {} of the {} timesteps each; pass a "
        "longer one",
        count, length, kLeastTimesteps, timesteps));
  // images of a window and of the timesteps beyond its ends
  const auto bytes_of = [&](int64_t windows) {
    const double steps = double(timesteps) / double(windows) + 2.0 * double(Window().overlap);
    return int64_t(double(bytes) * std::min(1.0, steps / double(timesteps)));
  };
  if (!is_asked)
    while (count < most && bytes_of(count) > room) ++count;
  count = std::min(count, most);
  if (bytes_of(count) > room)
    throw InputError(
        fmt::format("{}: the images of a window of {} take {:.1f} GB, and half of this machine's "
                    "memory is {:.1f} GB; pass shorter --windows, or prepare the capture with "
                    "--scale",
                    scene.path, count, double(bytes_of(count)) / 1e9, double(room) / 1e9));
  if (count <= 1) return {};
  return {count,
          fmt::format("windows: {:.1f} s are cut into {} windows of {:.1f} s; each holds "
                      "{:.2f} GB of images",
                      seconds, count, seconds / double(count), double(bytes_of(count)) / 1e9)};
}

}  // namespace tessera
