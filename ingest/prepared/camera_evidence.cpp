// Times are compared by numbers; single frames that differ do not decide against folders.
#include "ingest/prepared/camera_evidence.h"

#include <algorithm>
#include <numeric>

namespace tessera {
namespace {

constexpr double kEqualTimes = 1e-6;  // of the clip, as of timesteps
constexpr size_t kFewOfCamera = 10;   // one of so many frames does not decide

std::vector<int> time_numbers(const std::vector<UngroupedFrame>& frames) {
  FrameNumbers order(frames.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return frames[a].time < frames[b].time; });
  const double clip = frames[order.back()].time - frames[order.front()].time;
  std::vector<int> numbers(frames.size(), 0);
  for (size_t k = 1; k < order.size(); ++k) {
    const double gap = frames[order[k]].time - frames[order[k - 1]].time;
    numbers[order[k]] = numbers[order[k - 1]] + (gap > kEqualTimes * clip ? 1 : 0);
  }
  return numbers;
}

}  // namespace

LabelGroups by_label(const CameraLabels& labels, const FrameNumbers& frames) {
  LabelGroups groups;
  for (const size_t i : frames) groups[labels[i]].push_back(i);
  return groups;
}

CameraEvidence::CameraEvidence(const std::vector<UngroupedFrame>& frames)
    : frames_(frames),
      times_(time_numbers(frames)),
      latest_(*std::max_element(times_.begin(), times_.end())) {
  std::vector<std::string> names;
  std::map<std::pair<Split, int>, FrameNumbers> views;
  for (size_t i = 0; i < frames.size(); ++i) {
    names.push_back(frames[i].name);
    listing_.push_back(frames[i].listing);
    if (frames[i].stated) continue;
    open_[frames[i].split].push_back(i);
    views[{frames[i].split, frames[i].view}].push_back(i);
  }
  numbered_ = numbered_names(names);
  for (const auto& [view, seen] : views)
    if (seen.size() > 1 && repeated_times(seen) == 0) fixed_.insert(view);
}

std::set<int> CameraEvidence::fixed_views() const {
  std::set<int> views;
  for (const auto& [split, view] : fixed_) views.insert(view);
  return views;
}

bool CameraEvidence::is_fixed(size_t frame) const {
  return fixed_.contains({frames_[frame].split, frames_[frame].view});
}

size_t CameraEvidence::repeated_times(const FrameNumbers& frames) const {
  std::set<int> times;
  for (const size_t i : frames) times.insert(times_[i]);
  return frames.size() - times.size();
}

size_t CameraEvidence::repeated_times_of(const CameraLabels& labels,
                                         const FrameNumbers& frames) const {
  size_t repeated = 0;
  for (const auto& [label, group] : by_label(labels, frames)) repeated += repeated_times(group);
  return repeated;
}

/// How many of `frames` have a fixed view that is under several labels.
size_t CameraEvidence::scattered_views(const CameraLabels& labels,
                                       const FrameNumbers& frames) const {
  std::map<int, FrameNumbers> views;
  for (const size_t i : frames)
    if (is_fixed(i)) views[frames_[i].view].push_back(i);
  size_t scattered = 0;
  for (const auto& [view, seen] : views)
    if (by_label(labels, seen).size() > 1) scattered += seen.size();
  return scattered;
}

/// Whether a few views come in turns, as those of several cameras do whose clocks differ.
bool CameraEvidence::mixes_views(const FrameNumbers& group) const {
  FrameNumbers order = group;
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return times_[a] < times_[b]; });
  std::set<int> left;  // views that another one came after
  std::set<int> views{frames_[order.front()].view};
  size_t returned = 0;
  for (size_t k = 1; k < order.size(); ++k) {
    const int view = frames_[order[k]].view, before = frames_[order[k - 1]].view;
    if (view != before) left.insert(before);
    returned += left.contains(view);
    views.insert(view);
  }
  return kFewOfCamera * returned > order.size() && order.size() >= 3 * views.size();
}

/// Whether the numbered names in a group are those of several cameras: each has a number once and
/// most numbers come under several names at the same part of the clip, or views come in turns and
/// each name has one.
bool CameraEvidence::names_several(const FrameNumbers& group) const {
  std::map<std::string, FrameNumbers> series;
  std::map<int64_t, std::set<std::string>> names;
  for (const size_t i : group) {
    if (numbered_[i].number < 0) return false;
    series[numbered_[i].camera].push_back(i);
    names[numbered_[i].number].insert(numbered_[i].camera);
  }
  if (series.size() < 2 || group.size() < 2 * series.size()) return false;
  int begin = 0, end = latest_;
  bool has_one_view_each = mixes_views(group);
  for (const auto& [name, members] : series) {
    if (repeated_times(members) > 0) return false;
    const auto [first, last] = std::minmax_element(
        members.begin(), members.end(), [&](size_t a, size_t b) { return times_[a] < times_[b]; });
    begin = std::max(begin, times_[*first]);
    end = std::min(end, times_[*last]);
    has_one_view_each = has_one_view_each && !mixes_views(members);
  }
  size_t shared = 0;
  for (const auto& [number, cameras] : names)
    if (cameras.size() > 1) shared += cameras.size();
  return has_one_view_each || (2 * shared > group.size() && begin < end);
}

bool CameraEvidence::listing_holds() const {
  for (const auto& [split, open] : open_) {
    if (kFewOfCamera * repeated_times_of(listing_, open) > open.size()) return false;
    if (kFewOfCamera * scattered_views(listing_, open) > open.size()) return false;
    for (const auto& [label, group] : by_label(listing_, open))
      if (names_several(group)) return false;
  }
  return true;
}

bool CameraEvidence::names_hold(const CameraLabels& labels) const {
  FrameNumbers all;
  for (const auto& [split, open] : open_) {
    all.insert(all.end(), open.begin(), open.end());
    if (repeated_times_of(labels, open) > 0 || scattered_views(labels, open) > 0) return false;
    for (const auto& [label, group] : by_label(labels, open))
      if (label.empty() || names_several(group) || mixes_views(group)) return false;
  }
  return 2 * by_label(labels, all).size() <= all.size();
}

bool CameraEvidence::are_views(const CameraLabels& labels) const {
  size_t fixed = 0, all = 0;
  for (const auto& [split, open] : open_)
    for (const auto& [label, group] : by_label(labels, open)) {
      std::set<int> views;
      for (const size_t i : group)
        if (is_fixed(i)) views.insert(frames_[i].view), ++fixed;
      if (views.size() > 1) return false;
      all += group.size();
    }
  return 2 * fixed > all;
}

}  // namespace tessera
