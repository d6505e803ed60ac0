// Compares patches of a frame to those of up to eight other frames of its camera.
#include "ingest/cloud/still_pixels.h"

#include <algorithm>

#include "ingest/cloud/patch.h"
#include "kernels/base/median.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr float kStill = 4;         // change over time of a still pixel, levels
constexpr float kPassing = 12;      // likewise, of one before which something passes
constexpr int64_t kMostSights = 8;  // at which a pixel is compared
constexpr size_t kOfSights = 4;     // one of so many may show something that passes
constexpr size_t kEveryPixel = 17;  // of the image, for its light
constexpr float kMostRatio = 2;

/// As it would look in the light of another image.
Patch relit(Patch patch, const LightRatio& ratio) {
  for (size_t i = 0; i < patch.level.size(); ++i) patch.level[i] *= ratio[i % 3];
  for (size_t c = 0; c < 3; ++c) patch.mean[c] *= ratio[c];
  return patch;
}

}  // namespace

LightRatio light_ratio(const Image8& a, const Image8& b) {
  LightRatio ratio{1, 1, 1};
  const size_t pixels = a.data.size() / 3;
  if (pixels == 0 || a.data.size() != b.data.size()) return ratio;
  for (size_t c = 0; c < 3; ++c) {
    std::vector<float> ratios;
    for (size_t p = 0; p < pixels; p += kEveryPixel)
      ratios.push_back((float(a.data[3 * p + c]) + 1) / (float(b.data[3 * p + c]) + 1));
    ratio[c] = std::clamp(median_in_place(ratios), 1 / kMostRatio, kMostRatio);
  }
  return ratio;
}

StillPixels::StillPixels(const Scene& over_time) {
  std::map<std::string, std::vector<const Frame*>> frames;
  for (int i : over_time.split_indices(Split::kTrain)) {
    const Frame& frame = over_time.frames[size_t(i)];
    frames[frame.camera_name].push_back(&frame);
  }
  std::vector<Sight*> sights;
  for (const auto& [camera, all] : frames) {
    const auto total = int64_t(all.size()), count = std::min(total, kMostSights);
    for (int64_t i = 0; i < count; ++i)
      cameras_[camera].push_back({all[size_t(even_spread(i, count, total))], {1, 1, 1}});
  }
  for (auto& [camera, of_camera] : cameras_)
    for (Sight& sight : of_camera) sights.push_back(&sight);
  parallel_for(int64_t(sights.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i)
      sights[size_t(i)]->light = light_of(*sights[size_t(i)]->frame);
  });
}

LightRatio StillPixels::light_of(const Frame& frame) const {
  const auto camera = cameras_.find(frame.camera_name);
  if (camera == cameras_.end()) return {1, 1, 1};
  const Frame& first = *camera->second.front().frame;
  if (&first == &frame || !equal_pose(first.camera, frame.camera)) return {1, 1, 1};
  return light_ratio(frame.image, first.image);
}

bool StillPixels::still(const Frame& frame, const LightRatio& light, int x, int y) const {
  const auto camera = cameras_.find(frame.camera_name);
  if (camera == cameras_.end()) return true;
  const Patch patch = patch_at(frame.image, x, y);
  const size_t most = camera->second.size() / kOfSights;
  size_t passing = 0;
  const std::vector<Sight>& sights = camera->second;
  // frames lie far apart in memory: all patches are on their way before the first is compared
  for (const Sight& sight : sights) fetch_patch(sight.frame->image, x, y);
  for (const Sight& sight : sights) {
    if (!equal_pose(sight.frame->camera, frame.camera)) return true;
    const LightRatio ratio{light[0] / sight.light[0], light[1] / sight.light[1],
                           light[2] / sight.light[2]};
    const Patch then = relit(patch_at(sight.frame->image, x, y), ratio);
    const float change = std::max(difference(patch, then), brightness_difference(patch, then));
    if (change <= kStill) continue;
    // what passes has come and has gone
    const bool between = &sight != &sights.front() && &sight != &sights.back();
    if (change <= kPassing || !between) return false;
    ++passing;
    if (passing > most) return false;
  }
  return true;
}

}  // namespace tessera
