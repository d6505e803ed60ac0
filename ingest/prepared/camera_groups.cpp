// The cameras are found as labels first and get their names afterwards.
#include "ingest/prepared/camera_groups.h"

#include <fmt/format.h>

#include <algorithm>

namespace tessera {
namespace {

/// Cameras as labels, and what told them.
struct LabelledCameras {
  CameraLabels labels;
  std::string why;
};

FrameNumbers open_frames(const CameraEvidence& evidence) {
  FrameNumbers all;
  for (const auto& [split, open] : evidence.open()) all.insert(all.end(), open.begin(), open.end());
  return all;
}

/// Whether a reading of the names has cameras' names for all frames, and two of them. Numbers alone
/// are those of frames as well.
bool says_cameras(const CameraLabels& reading, const FrameNumbers& frames) {
  const LabelGroups cameras = by_label(reading, frames);
  return cameras.size() > 1 && std::all_of(cameras.begin(), cameras.end(), [](const auto& camera) {
           return is_camera_name(camera.first) &&
                  camera.first.find_first_not_of("0123456789_") != std::string::npos;
         });
}

/// Fixed views are cameras. A split's other frames are one that moves, or a camera each.
LabelledCameras cameras_by_view(const std::vector<UngroupedFrame>& frames,
                                const CameraEvidence& evidence,
                                const std::vector<CameraLabels>& readings) {
  LabelledCameras found{CameraLabels(frames.size()), "by their poses"};
  const std::set<int> fixed = evidence.fixed_views();
  size_t alone = 0;
  for (const auto& [split, open] : evidence.open()) {
    FrameNumbers others;
    for (const size_t i : open)
      if (fixed.contains(frames[i].view))
        found.labels[i] = fmt::format("view {}", frames[i].view);
      else
        others.push_back(i);
    const bool is_one = 3 * evidence.repeated_times(others) <= others.size();
    for (const size_t i : others)
      found.labels[i] = is_one ? "moving " + frames[i].listing
                               : fmt::format("split {} view {}", int(split), frames[i].view);
    if (!is_one) alone += others.size();
  }
  const FrameNumbers all = open_frames(evidence);
  if (2 * alone > all.size())
    found.why =
        "because several have one time, and neither poses nor names tell which are of one camera";
  else if (std::any_of(readings.begin(), readings.end(),
                       [&](const CameraLabels& reading) { return says_cameras(reading, all); }))
    found.why += ", which the names of the images contradict";
  return found;
}

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
  for (const auto& [label, group] : cameras) {
    const std::string& name = reading[group.front()];
    const bool is_one =
        std::all_of(group.begin(), group.end(), [&](size_t i) { return reading[i] == name; });
    if (!is_one || name.empty() || !taken.insert(name).second) return false;
  }
  return true;
}

/// Sets the names of `cameras`: by the first reading that has one for each, else numbers.
void name_cameras(const std::vector<UngroupedFrame>& frames, const LabelGroups& cameras,
                  const std::vector<CameraLabels>& readings, std::vector<std::string>& names) {
  std::set<std::string> taken;
  for (const UngroupedFrame& frame : frames)
    if (frame.stated) taken.insert(frame.listing);
  const auto reading = std::find_if(
      readings.begin(), readings.end(),
      [&](const CameraLabels& candidate) { return names_all(candidate, cameras, taken); });
  if (reading == readings.end()) return number_cameras(frames, cameras, taken, names);
  for (const auto& [label, group] : cameras)
    for (const size_t i : group) names[i] = (*reading)[i];
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

}  // namespace

CameraGroups group_cameras(const std::vector<UngroupedFrame>& frames) {
  CameraGroups groups;
  std::vector<std::string> names;
  for (const UngroupedFrame& frame : frames) {
    names.push_back(frame.name);
    groups.cameras.push_back(frame.listing);
  }
  if (frames.empty()) return groups;
  const CameraEvidence evidence(frames);
  if (evidence.has_one_time() || evidence.listing_holds()) return groups;
  std::vector<CameraLabels> readings = camera_labels(names);
  const auto holds =
      std::find_if(readings.begin(), readings.end(),
                   [&](const CameraLabels& labels) { return evidence.names_hold(labels); });
  LabelledCameras found;
  if (holds == readings.end())
    found = cameras_by_view(frames, evidence, readings);
  else
    found = {*holds,
             evidence.are_views(*holds) ? "by their poses" : "by the names of their images"};
  readings.insert(readings.begin(), groups.cameras);
  const LabelGroups cameras = by_label(found.labels, open_frames(evidence));
  name_cameras(frames, cameras, readings, groups.cameras);
  groups.regrouped = true;
  groups.note = note_of(cameras, found.why);
  return groups;
}

}  // namespace tessera
