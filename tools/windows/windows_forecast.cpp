// The forecast of one window, as often as there are windows for a card.
#include "tools/windows/windows_forecast.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "ingest/clocks/windows.h"
#include "kernels/base/errors.h"
#include "recon4d/options/forecast.h"
#include "recon4d/options/presets.h"

namespace tessera {
namespace {

constexpr double kDecodedPixels = 27e6;  // a second of a core, H.264
constexpr double kBesideSteps = 2;       // cloud, decisions and scores, by the seconds of steps

/// The frames of the window in the middle, which has timesteps beyond both ends.
Scene middle_window(const Scene& scene, int64_t windows) {
  Window window;
  window.index = windows / 2;
  window.count = windows;
  const TimestepRange range = range_of(window, timesteps_of(scene));
  Scene part;
  std::copy_if(scene.frames.begin(), scene.frames.end(), std::back_inserter(part.frames),
               [&](const Frame& frame) {
                 return frame.timestep >= range.first && frame.timestep <= range.last;
               });
  return part;
}

}  // namespace

WindowsForecast forecast_windows(const WindowWish& wish, const Scene& scene, int64_t memory,
                                 int threads) {
  WindowsForecast forecast;
  if (wish.kind == WindowWish::Kind::kLength)
    if (const std::string reason = reason_against_windows(scene); !reason.empty()) {
      forecast.line = whole_clip_text(reason);
      return forecast;
    }
  try {
    forecast.windows = choose_windows(wish, scene, memory).count;
  } catch (const InputError& error) {
    forecast.fits = false;
    forecast.line = error.what();
    return forecast;
  }
  if (forecast.windows <= 1) return forecast;
  const Scene part = middle_window(scene, forecast.windows);
  TrainOptions options;
  apply_preset(options, "balanced", facts_of(part));
  ForecastLoad load = forecast_load(part);
  load.threads = threads;
  const TrainForecast one = forecast_training(load, options);
  const double decoding = double(load.image_bytes) / 3 / kDecodedPixels / double(threads),
               seconds = decoding + kBesideSteps * one.gpu_seconds;
  nlohmann::json hours = nlohmann::json::object();
  std::string text;
  for (const int64_t cards : {1, 2, 8, 64}) {
    const int64_t rounds = (forecast.windows + cards - 1) / cards;
    const double all = double(rounds) * seconds / 3600;
    hours[fmt::format("{}", cards)] = all;
    text += fmt::format("{}{:.2g} h on {}", text.empty() ? "" : ", ", all, cards);
  }
  forecast.table = {{"windows", forecast.windows},
                    {"seconds", scene.time_axis.duration / double(forecast.windows)},
                    {"images", part.frames.size()},
                    {"host_bytes", one.host_bytes},
                    {"device_bytes", one.device_bytes},
                    {"window_seconds", seconds},
                    {"hours", std::move(hours)}};
  forecast.line = fmt::format(
      "trained in {} windows of {:.1f} s: each {} images, {:.2f} GiB of memory and {:.2f} GiB of a "
      "GPU's, {:.0f} s of a card like an H200; in all {} cards (within a factor of 3)",
      forecast.windows, scene.time_axis.duration / double(forecast.windows), part.frames.size(),
      double(one.host_bytes) / double(int64_t{1} << 30),
      double(one.device_bytes) / double(int64_t{1} << 30), seconds, text);
  return forecast;
}

}  // namespace tessera
