// What: counts by camera, and the sentence made of them.
// Not: scores.
#include "ingest/test_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "ingest/held_out_cameras.h"

namespace tessera {

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
  return fmt::format("{} {} view{} ({})", held_out, split, held_out == 1 ? "" : "s", cameras);
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
