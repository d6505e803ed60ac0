// Assigns splits to cameras and images by name or by number, and counts the test views of each
// camera.
#include "ingest/test_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <numeric>
#include <vector>

#include "kernels/base/counted.h"
#include "kernels/base/errors.h"

namespace tessera {

std::string listed_names(const std::vector<std::string>& names) {
  constexpr size_t kMost = 12;
  const size_t shown = std::min(names.size(), kMost);
  std::string list =
      fmt::format("{}", fmt::join(names.begin(), names.begin() + ptrdiff_t(shown), ", "));
  if (shown < names.size()) list += fmt::format(" and {} more", names.size() - shown);
  return list;
}

std::vector<std::string> whole_names(const std::vector<std::string>& list,
                                     const std::vector<std::string>& known) {
  std::vector<std::string> names;
  for (size_t i = 0; i < list.size();) {
    names.push_back(list[i]);
    std::string joined = list[i];
    size_t next = i + 1;
    for (size_t k = i + 1; k < list.size(); ++k) {
      joined += "," + list[k];
      if (std::find(known.begin(), known.end(), joined) == known.end()) continue;
      names.back() = joined;
      next = k + 1;
    }
    i = next;
  }
  return names;
}

std::vector<Split> held_out_splits_of(const std::vector<std::string>& cameras,
                                      const std::vector<std::string>& held_out,
                                      const std::string& layout) {
  const std::vector<std::string> none{kHeldOutNone};
  if (held_out == none && std::find(cameras.begin(), cameras.end(), none[0]) == cameras.end())
    return std::vector<Split>(cameras.size(), Split::kTrain);
  std::vector<Split> splits(cameras.size(), Split::kTrain);
  for (const std::string& name : whole_names(held_out, cameras)) {
    const auto found = std::find(cameras.begin(), cameras.end(), name);
    if (found == cameras.end())
      throw InputError(fmt::format("{}: no camera '{}' to hold out; the cameras are {}", layout,
                                   name, listed_names(cameras)));
    splits[size_t(found - cameras.begin())] = Split::kTest;
  }
  if (std::find(splits.begin(), splits.end(), Split::kTrain) == splits.end())
    throw InputError(fmt::format(
        "{}: all cameras are held out, none is left to train on; hold out fewer", layout));
  return splits;
}

size_t innermost(const std::vector<glm::dvec3>& centres) {
  constexpr double kAlike = 1.02;
  std::vector<double> distances;
  for (const glm::dvec3& centre : centres) {
    double& sum = distances.emplace_back(0);
    for (const glm::dvec3& other : centres) sum += glm::length(other - centre);
  }
  const double least = *std::min_element(distances.begin(), distances.end());
  const auto found = std::find_if(distances.begin(), distances.end(),
                                  [&](double distance) { return distance <= kAlike * least; });
  return size_t(found - distances.begin());
}

std::vector<Split> every_nth_split(const std::vector<std::string>& names, int64_t every) {
  if (every < 0 || every == 1)
    throw InputError(
        fmt::format("--test-every is {}, expected 2 or more, or 0 to hold none out", every));
  std::vector<size_t> order(names.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return names[a] < names[b]; });
  std::vector<Split> splits(names.size(), Split::kTrain);
  for (size_t i = 0; every > 0 && i < order.size(); i += size_t(every))
    splits[order[i]] = Split::kTest;
  return splits;
}

void TestViews::add(const Frame& frame) {
  Counts& counts = cameras_[frame.camera_name];
  ++counts.all;
  if (frame.split == Split::kTest) ++counts.test;
  if (frame.split == Split::kVal) ++counts.val;
}

int64_t TestViews::count() const {
  int64_t views = 0;
  for (const auto& [name, counts] : cameras_) views += counts.test + counts.val;
  return views;
}

std::string TestViews::text_of(const char* split, int64_t Counts::*views) const {
  std::vector<std::string> names;
  int64_t held_out = 0, frames = 0;
  bool single_views = true;
  for (const auto& [name, counts] : cameras_) {
    if (counts.*views == 0) continue;
    names.push_back(name);
    held_out += counts.*views;
    frames += counts.all;
    single_views = single_views && counts.all == 1;
  }
  if (held_out == 0) return "";
  const char* noun = names.size() == 1 ? "camera" : single_views ? "images" : "cameras";
  std::string cameras = fmt::format("{} {}", noun, listed_names(names));
  if (held_out < frames) cameras = fmt::format("{} of the {} of {}", held_out, frames, cameras);
  return fmt::format("{} ({})", counted(held_out, fmt::format("{} view", split)), cameras);
}

std::string TestViews::text() const {
  const std::string test = text_of("test", &Counts::test), val = text_of("val", &Counts::val);
  if (test.empty() && val.empty())
    return "nothing will be scored, because the scene has no test views; prepare it with "
           "--test-every 8 (photos, transforms files, one moving camera) or --held-out CAMERA "
           "(several cameras) to change that";
  return fmt::format("will be scored: {}{}{}", test, test.empty() || val.empty() ? "" : ", ", val);
}

TestViews test_views_of(const Scene& scene) {
  TestViews views;
  for (const Frame& frame : scene.frames) views.add(frame);
  return views;
}

}  // namespace tessera
