// The cameras are found as labels first and get their names afterwards.
#include "ingest/prepared/camera_groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "ingest/prepared/camera_labels.h"

namespace tessera {
namespace {

using FrameNumbers = std::vector<size_t>;
using LabelGroups = std::map<std::string, FrameNumbers>;  // by label

/// Equal numbers for times within a millionth of the clip, ascending.
std::vector<int> time_numbers(const std::vector<UngroupedFrame>& frames) {
  constexpr double kEqual = 1e-6;
  FrameNumbers order(frames.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return frames[a].time < frames[b].time; });
  const double clip = frames[order.back()].time - frames[order.front()].time;
  std::vector<int> numbers(frames.size(), 0);
  for (size_t k = 1; k < order.size(); ++k) {
    const double gap = frames[order[k]].time - frames[order[k - 1]].time;
    numbers[order[k]] = numbers[order[k - 1]] + (gap > kEqual * clip ? 1 : 0);
  }
  return numbers;
}

LabelGroups by_label(const CameraLabels& labels, const FrameNumbers& frames) {
  LabelGroups groups;
  for (const size_t i : frames) groups[labels[i]].push_back(i);
  return groups;
}

/// The frames without a stated camera, and readings of their cameras.
class OpenFrames {
 public:
  explicit OpenFrames(const std::vector<UngroupedFrame>& frames)
      : frames_(frames), times_(time_numbers(frames)) {
    std::map<std::pair<Split, int>, FrameNumbers> views;
    for (size_t i = 0; i < frames.size(); ++i) {
      if (frames[i].stated) continue;
      all_.push_back(i);
      of_split_[frames[i].split].push_back(i);
      views[{frames[i].split, frames[i].view}].push_back(i);
    }
    for (const auto& [view, seen] : views)
      if (seen.size() > 1 && repeated_times(seen) == 0) fixed_.insert(view.second);
  }

  const FrameNumbers& all() const { return all_; }
  bool has_one_time() const { return *std::max_element(times_.begin(), times_.end()) == 0; }

  /// Whether no more than a share of the frames of each split speak against the labels.
  bool fit(const CameraLabels& labels, double share) const {
    return std::all_of(of_split_.begin(), of_split_.end(), [&](const auto& split) {
      const size_t against = repeats(labels, split.second) + scattered(labels, split.second);
      return double(against) <= share * double(split.second.size());
    });
  }

  /// Whether several labels have two images in the mean, and all film half of the clip together.
  bool film_together(const CameraLabels& labels) const {
    const LabelGroups groups = by_label(labels, all_);
    if (groups.size() < 2 || groups.contains("") || 2 * groups.size() > all_.size()) return false;
    int begin = 0, end = std::numeric_limits<int>::max();
    for (const auto& [label, group] : groups) {
      const auto [first, last] = std::minmax_element(
          group.begin(), group.end(), [&](size_t a, size_t b) { return times_[a] < times_[b]; });
      begin = std::max(begin, times_[*first]);
      end = std::min(end, times_[*last]);
    }
    return 2 * (end - begin) >= *std::max_element(times_.begin(), times_.end());
  }

  /// Views that come at several times are cameras; a split's other frames are one that moves, where
  /// they have nearly one image a time, else a camera each, as are all without such views.
  CameraLabels labels_of_views() const {
    CameraLabels labels(frames_.size());
    for (const auto& [split, open] : of_split_) {
      FrameNumbers others;
      for (const size_t i : open)
        if (fixed_.contains(frames_[i].view))
          labels[i] = fmt::format("view {}", frames_[i].view);
        else
          others.push_back(i);
      const bool is_one = 3 * repeated_times(others) <= others.size();
      for (const size_t i : others)
        labels[i] = is_one ? "moving " + frames_[i].listing
                           : fmt::format("split {} view {}", int(split), frames_[i].view);
    }
    return labels;
  }

 private:
  size_t repeated_times(const FrameNumbers& frames) const {
    std::set<int> times;
    for (const size_t i : frames) times.insert(times_[i]);
    return frames.size() - times.size();
  }
  size_t repeats(const CameraLabels& labels, const FrameNumbers& frames) const {
    size_t repeated = 0;
    for (const auto& [label, group] : by_label(labels, frames)) repeated += repeated_times(group);
    return repeated;
  }
  /// How many of `frames` have a fixed view that is under several labels.
  size_t scattered(const CameraLabels& labels, const FrameNumbers& frames) const {
    std::map<int, FrameNumbers> views;
    for (const size_t i : frames)
      if (fixed_.contains(frames_[i].view)) views[frames_[i].view].push_back(i);
    size_t count = 0;
    for (const auto& [view, seen] : views)
      if (by_label(labels, seen).size() > 1) count += seen.size();
    return count;
  }

  const std::vector<UngroupedFrame>& frames_;
  const std::vector<int> times_;
  FrameNumbers all_;
  std::map<Split, FrameNumbers> of_split_;
  std::set<int> fixed_;  // views
};

/// camera_0 … in the order of the first names of their frames; `taken` are left out.
void number_cameras(const std::vector<UngroupedFrame>& frames, const LabelGroups& cameras,
                    const std::set<std::string>& taken, std::vector<std::string>& names) {
  const auto by_name = [&](size_t a, size_t b) { return frames[a].name < frames[b].name; };
  std::map<std::string, const FrameNumbers*> by_first;
  for (const auto& [label, group] : cameras)
    by_first[frames[*std::min_element(group.begin(), group.end(), by_name)].name] = &group;
  size_t number = 0;
  for (const auto& [first, group] : by_first) {
    while (taken.contains(fmt::format("camera_{}", number))) ++number;
    for (const size_t i : *group) names[i] = fmt::format("camera_{}", number);
    ++number;
  }
}

/// Whether the reading has a name for each camera that no other has.
bool names_all(const CameraLabels& reading, const LabelGroups& cameras,
               std::set<std::string> taken) {
  return std::all_of(cameras.begin(), cameras.end(), [&](const auto& camera) {
    const FrameNumbers& group = camera.second;
    const std::string& name = reading[group.front()];
    return !name.empty() && taken.insert(name).second &&
           std::all_of(group.begin(), group.end(), [&](size_t i) { return reading[i] == name; });
  });
}

/// Sets the names of `cameras`: by the first reading that has one for each, else numbers. Whether a
/// reading has.
bool name_cameras(const std::vector<UngroupedFrame>& frames, const LabelGroups& cameras,
                  const std::vector<CameraLabels>& readings, std::vector<std::string>& names) {
  std::set<std::string> taken;
  for (const UngroupedFrame& frame : frames)
    if (frame.stated) taken.insert(frame.listing);
  for (const CameraLabels& reading : readings) {
    if (!names_all(reading, cameras, taken)) continue;
    for (const auto& [label, group] : cameras)
      for (const size_t i : group) names[i] = reading[i];
    return true;
  }
  number_cameras(frames, cameras, taken, names);
  return false;
}

std::string note_of(const LabelGroups& cameras, const std::string& why) {
  size_t least = cameras.begin()->second.size(), most = least;
  for (const auto& [label, group] : cameras) {
    least = std::min(least, group.size());
    most = std::max(most, group.size());
  }
  const std::string images =
      least == most ? fmt::format("{}", most) : fmt::format("{} to {}", least, most);
  const bool is_one = cameras.size() == 1;
  return fmt::format("read as {} camera{} with {} image{}{}, {}", cameras.size(), is_one ? "" : "s",
                     images, most == 1 ? "" : "s", is_one ? "" : " each", why);
}

/// What the keys of entries say, then their names.
std::vector<CameraLabels> readings_of(const std::vector<UngroupedFrame>& frames) {
  std::vector<std::string> names;
  CameraLabels stated;
  for (const UngroupedFrame& frame : frames) {
    names.push_back(frame.name);
    stated.push_back(frame.camera);
  }
  std::vector<CameraLabels> readings = camera_labels(names);
  readings.insert(readings.begin(), std::move(stated));
  return readings;
}

}  // namespace

CameraGroups group_cameras(const std::vector<UngroupedFrame>& frames) {
  constexpr double kFew = 0.1;  // of the frames, which do not decide against folders
  CameraGroups groups;
  for (const UngroupedFrame& frame : frames) groups.cameras.push_back(frame.listing);
  if (frames.empty()) return groups;
  const OpenFrames open(frames);
  if (open.has_one_time()) return groups;
  std::vector<CameraLabels> readings = readings_of(frames);
  const auto holds =
      std::find_if(readings.begin(), readings.end(), [&](const CameraLabels& labels) {
        return open.film_together(labels) && open.fit(labels, 0);
      });
  const bool is_told = holds != readings.end();
  if (!is_told && open.fit(groups.cameras, kFew)) return groups;
  const LabelGroups cameras = by_label(is_told ? *holds : open.labels_of_views(), open.all());
  const LabelGroups listed = by_label(groups.cameras, open.all());
  const bool as_listed = std::all_of(cameras.begin(), cameras.end(), [&](const auto& camera) {
    return listed.at(groups.cameras[camera.second.front()]) == camera.second;
  });
  if (as_listed) return groups;
  std::string why = is_told ? holds == readings.begin() ? "as their entries state"
                                                        : "by the names of their images"
                            : "by their poses";
  readings.insert(readings.begin(), groups.cameras);
  const bool are_named = name_cameras(frames, cameras, readings, groups.cameras);
  if (!is_told && 2 * cameras.size() > open.all().size())
    why =
        "because several have one time, and neither poses nor names tell which are of one camera; "
        "state `camera` in each frame";
  else if (!are_named)
    why += ", which their names do not tell";
  groups.regrouped = true;
  groups.note = note_of(cameras, why);
  return groups;
}

}  // namespace tessera
