// Images are read only where frames have equal views.
#include "ingest/prepared/frame_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/files/atomic_file.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr double kFramesPerSecond = 30;  // of numbers of frames: for the axis alone

const std::set<std::string> kTimes{"time", "timestamp", "stamp", "t", "seconds", "sec"};
const std::set<std::string> kUnits{"frame", "image", "capture", "s", "ms", "us", "ns"};
const std::set<std::string> kCounts{"frame", "time", "timestep", "step"};
const std::set<std::string> kIndices{"id", "idx", "index", "number", "no", "nr"};

bool is_time(const std::string& key) {
  return is_of_words(key, kTimes, kUnits);
}

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

using Frames = std::vector<size_t>;  // their numbers

/// What frames with equal views show about time.
struct SeenViews {
  const std::vector<TransformsFrame>& frames;
  const std::vector<int>& views;
  std::vector<Frames> changing{};  // by view the frames of one split, where their images differ

  size_t changing_frames() const {
    size_t count = 0;
    for (const Frames& group : changing) count += group.size();
    return count;
  }
};

/// By their bytes.
bool images_differ(const std::vector<TransformsFrame>& frames, const Frames& group) {
  const std::filesystem::path& first = frames[group.front()].image;
  return std::any_of(group.begin() + 1, group.end(), [&](size_t i) {
    const std::filesystem::path& other = frames[i].image;
    if (first.empty() || other.empty() || first == other) return false;
    return std::filesystem::file_size(first) != std::filesystem::file_size(other) ||
           read_text_file(first) != read_text_file(other);
  });
}

SeenViews seen_views(const std::vector<TransformsFrame>& frames, const std::vector<int>& views) {
  SeenViews seen{frames, views};
  std::map<std::pair<Split, int>, Frames> groups;
  for (size_t i = 0; i < views.size(); ++i) groups[{frames[i].split, views[i]}].push_back(i);
  for (auto& [view, group] : groups)
    if (group.size() > 1 && images_differ(frames, group)) seen.changing.push_back(std::move(group));
  return seen;
}

/// A key that all frames have a number under, with several values.
struct Key {
  std::string name;
  std::vector<double> values;  // of the frames
  size_t shared = 0;           // frames whose value an image of another view has, too
  size_t told = 0;             // frames of changing views in which it changes
  bool repeats = false;        // within a changing view

  /// It follows time. One in ten frames may stand out.
  bool follows() const { return 10 * told > values.size() || 2 * shared > values.size(); }
};

std::optional<Key> key_of(const std::string& name, const SeenViews& seen) {
  Key key{name, {}};
  for (const TransformsFrame& frame : seen.frames) {
    const auto found = frame.other_times.find(name);
    if (found == frame.other_times.end() || !std::isfinite(found->second)) return std::nullopt;
    key.values.push_back(found->second);
  }
  std::map<double, std::set<int>> views;  // by value
  for (size_t i = 0; i < key.values.size(); ++i) views[key.values[i]].insert(seen.views[i]);
  if (views.size() < 2) return std::nullopt;
  for (const double value : key.values) key.shared += views[value].size() > 1;
  for (const Frames& group : seen.changing) {
    std::set<double> values;
    for (const size_t i : group) values.insert(key.values[i]);
    if (values.size() > 1) key.told += group.size();
    key.repeats = key.repeats || values.size() < group.size();
  }
  return key;
}

/// Times before counts.
std::vector<Key> keys_of(const SeenViews& seen) {
  std::vector<Key> keys;
  for (const bool times : {true, false})
    for (const auto& [name, value] : seen.frames.front().other_times)
      if (is_time(name) == times)
        if (std::optional<Key> key = key_of(name, seen)) keys.push_back(std::move(*key));
  return keys;
}

/// Whether one key increases where the other decreases: within a view, or in the whole capture
/// where no view has several images.
bool disagree(const Key& one, const Key& other, const SeenViews& seen) {
  std::vector<Frames> groups = seen.changing;
  if (groups.empty()) {
    groups.emplace_back();
    for (size_t i = 0; i < one.values.size(); ++i) groups.back().push_back(i);
  }
  const auto values = [&](size_t i) { return std::pair(one.values[i], other.values[i]); };
  return std::any_of(groups.begin(), groups.end(), [&](Frames group) {
    std::sort(group.begin(), group.end(),
              [&](size_t a, size_t b) { return values(a) < values(b); });
    return !std::is_sorted(group.begin(), group.end(),
                           [&](size_t a, size_t b) { return other.values[a] < other.values[b]; });
  });
}

/// The keys of entries that may be times, for messages.
std::vector<std::string> names_of_keys(const TransformsCapture& capture) {
  std::set<std::string> names;
  for (const TransformsFrame& frame : capture.frames)
    for (const auto& [key, value] : frame.other_times)
      names.insert(std::isfinite(value) ? key : key + " (no number)");
  return {names.begin(), names.end()};
}

void take_key(const Key& key, TransformsCapture& capture) {
  const bool counts = !is_time(key.name);
  for (size_t i = 0; i < key.values.size(); ++i)
    capture.frames[i].time = key.values[i] / (counts ? kFramesPerSecond : 1);
  capture.notes.push_back(
      fmt::format("{}: times are those of `{}`{}", capture.files.front().string(), key.name,
                  counts ? fmt::format(", counted at {} a second", kFramesPerSecond) : ""));
}

/// Of a capture that stays without times.
void note_static(const SeenViews& seen, const std::vector<Key>& keys, TransformsCapture& capture) {
  const std::string file = capture.files.front().string();
  if (!seen.changing.empty()) {
    const Frames& example = seen.changing.front();
    const std::vector<std::string> names = names_of_keys(capture);
    const std::string message = fmt::format(
        "{}: {} and {} have one pose and different images, and no frame has `time`{}; state `time` "
        "in each frame, or one time for all and --static for a scene that stands still",
        file, capture.frames[example[0]].name, capture.frames[example[1]].name,
        names.empty() ? "" : fmt::format(" (there is {})", listed_names(names)));
    if (2 * seen.changing_frames() > capture.frames.size()) throw InputError(message);
    capture.warnings.push_back(message);
  } else if (!keys.empty()) {
    std::vector<std::string> names;
    for (const Key& key : keys) names.push_back(key.name);
    capture.notes.push_back(fmt::format(
        "{}: read as a scene that stands still, as each view has one image; {} is not used: call "
        "it `time` if the scene moves",
        file, listed_names(names)));
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
  for (const auto& [key, value] : entry.members()) {
    if (key == "time" || (!is_time(key) && !is_of_words(key, kCounts, kIndices))) continue;
    entry.take(key);
    values[key] = number_in(*value).value_or(std::numeric_limits<double>::quiet_NaN());
  }
  return values;
}

void choose_times(TransformsCapture& capture, const std::vector<int>& views) {
  if (std::any_of(capture.frames.begin(), capture.frames.end(),
                  [](const TransformsFrame& frame) { return frame.time.has_value(); }))
    return;
  const SeenViews seen = seen_views(capture.frames, views);
  const std::vector<Key> all = keys_of(seen);
  std::vector<Key> keys = all;
  std::erase_if(keys, [](const Key& key) { return !key.follows(); });
  if (keys.empty()) return note_static(seen, all, capture);
  for (const Key& key : keys)
    if (disagree(keys.front(), key, seen))
      throw InputError(
          fmt::format("{}: `{}` and `{}` differ in the order of frames; state `time` in each frame",
                      capture.files.front().string(), keys.front().name, key.name));
  const std::string first = keys.front().name;
  std::erase_if(keys, [&](const Key& key) {  // numbers of images, not of a camera's frames
    return !is_time(key.name) && seen.changing.size() > 1 && key.shared == 0;
  });
  if (keys.empty())
    throw InputError(fmt::format(
        "{}: `{}` counts the images of all cameras, so it is no time; state `time` in each frame",
        capture.files.front().string(), first));
  const auto once =
      std::find_if(keys.begin(), keys.end(), [](const Key& key) { return !key.repeats; });
  take_key(once == keys.end() ? keys.front() : *once, capture);
}

}  // namespace tessera
