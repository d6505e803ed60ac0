// Keys are tried in the order of the tables; images are read only where frames have equal views.
#include "ingest/prepared/frame_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/prepared/views_over_time.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr double kFramesPerSecond = 30;  // of numbers of frames: for the axis alone

struct TimeKey {
  const char* name;
  bool counts_frames;
};

constexpr std::array<TimeKey, 23> kTimeKeys{{
    {"timestamp", false},
    {"timestamp_s", false},
    {"timestamp_ms", false},
    {"timestamp_us", false},
    {"timestamp_ns", false},
    {"time_stamp", false},
    {"t", false},
    {"frame_time", false},
    {"time_sec", false},
    {"time_seconds", false},
    {"time_s", false},
    {"time_ms", false},
    {"time_us", false},
    {"time_ns", false},
    {"seconds", false},
    {"frame_id", true},
    {"frame_index", true},
    {"frame_idx", true},
    {"time_id", true},
    {"timestep", true},
    {"timestep_index", true},
    {"frame_number", true},
    {"frame", true},
}};

/// A number, or text that is one and nothing else.
std::optional<double> number_in(const json& value) {
  if (value.is_number()) return value.get<double>();
  if (!value.is_string()) return std::nullopt;
  const auto& text = value.get_ref<const std::string&>();
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// The keys of entries that may be times, for messages.
std::vector<std::string> keys_of(const TransformsCapture& capture) {
  std::set<std::string> keys;
  for (const TransformsFrame& frame : capture.frames)
    for (const auto& [key, value] : frame.other_times)
      keys.insert(std::isfinite(value) ? key : key + " (no number)");
  return {keys.begin(), keys.end()};
}

void take_key(TransformsCapture& capture, const TimeKey& key) {
  for (TransformsFrame& frame : capture.frames)
    frame.time = frame.other_times.at(key.name) / (key.counts_frames ? kFramesPerSecond : 1);
  capture.notes.push_back(fmt::format(
      "{}: times are those of `{}`{}", capture.files.front().string(), key.name,
      key.counts_frames ? fmt::format(", counted at {} a second", kFramesPerSecond) : ""));
}

/// Of a capture that stays without times.
void note_static(TransformsCapture& capture, const ViewsOverTime& views) {
  const std::string file = capture.files.front().string();
  std::vector<std::string> unused;
  for (const TimeKey& key : kTimeKeys)
    if (views.is_on_all(key.name) && views.has_several(key.name)) unused.push_back(key.name);
  if (!views.changing().empty()) {
    const std::vector<size_t>& example = views.changing().front();
    const std::vector<std::string> keys = keys_of(capture);
    const std::string message = fmt::format(
        "{}: {} and {} have one pose and different images, and no frame has `time`{}; state `time` "
        "in each frame, or one time for all and --static for a scene that stands still",
        file, capture.frames[example[0]].name, capture.frames[example[1]].name,
        keys.empty() ? "" : fmt::format(" (there is {})", listed_names(keys)));
    if (2 * views.changing_frames() > capture.frames.size()) throw InputError(message);
    capture.warnings.push_back(message);
  } else if (!unused.empty()) {
    capture.notes.push_back(fmt::format(
        "{}: read as a scene that stands still, as each view has one image; {} is not used: call "
        "it `time` if the scene moves",
        file, listed_names(unused)));
  }
}

}  // namespace

std::optional<double> stated_time(const StatedObject& entry) {
  const json* const found = entry.at("time");
  if (found == nullptr || !found->is_string()) return entry.number("time");
  const std::optional<double> number = number_in(*found);
  if (!number || !std::isfinite(*number))
    throw InputError(fmt::format("{}: time is \"{}\", expected a finite number; correct it",
                                 entry.where(), found->get<std::string>()));
  return number;
}

std::map<std::string, double> other_times_of(const StatedObject& entry) {
  std::map<std::string, double> values;
  for (const TimeKey& key : kTimeKeys)
    if (const json* const found = entry.at(key.name))
      values[key.name] = number_in(*found).value_or(std::numeric_limits<double>::quiet_NaN());
  return values;
}

void choose_times(TransformsCapture& capture, const std::vector<int>& views) {
  if (std::any_of(capture.frames.begin(), capture.frames.end(),
                  [](const TransformsFrame& frame) { return frame.time.has_value(); }))
    return;
  const ViewsOverTime seen(capture.frames, views);
  std::vector<TimeKey> keys;
  for (const TimeKey& key : kTimeKeys)
    if (seen.is_on_all(key.name) && seen.follows_time(key.name)) keys.push_back(key);
  for (size_t k = 1; k < keys.size(); ++k)
    if (seen.disagree(keys[0].name, keys[k].name))
      throw InputError(
          fmt::format("{}: `{}` and `{}` differ in the order of frames; state `time` in each frame",
                      capture.files.front().string(), keys[0].name, keys[k].name));
  const std::vector<TimeKey> followers = keys;
  std::erase_if(
      keys, [&](const TimeKey& key) { return key.counts_frames && seen.counts_through(key.name); });
  if (keys.empty() && !followers.empty())
    throw InputError(fmt::format(
        "{}: `{}` counts the images of all cameras, so it is no time; state `time` in each frame",
        capture.files.front().string(), followers.front().name));
  if (keys.empty()) return note_static(capture, seen);
  const auto once = std::find_if(keys.begin(), keys.end(),
                                 [&](const TimeKey& key) { return !seen.repeats(key.name); });
  take_key(capture, once == keys.end() ? keys.front() : *once);
}

}  // namespace tessera
