// Chooses the times that a frame is compared with, and measures its light.
#include "ingest/cloud/still_pixels.h"

#include <algorithm>

#include "ingest/cloud/grey_patch.h"
#include "kernels/base/median.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr int64_t kMostTimes = kMostStillSights;  // at which a pixel is compared
constexpr size_t kEveryPixel = 17;                // of the image, for its light
constexpr float kMostRatio = 2;

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
    const auto total = int64_t(all.size()), count = std::min(total, kMostTimes);
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

std::vector<StillSight> StillPixels::sights_of(const Frame& frame, const LightRatio& light) const {
  std::vector<StillSight> found;
  const auto camera = cameras_.find(frame.camera_name);
  if (camera == cameras_.end()) return found;
  for (const Sight& sight : camera->second)
    found.push_back(
        {rgb_of(sight.frame->image),
         {light[0] / sight.light[0], light[1] / sight.light[1], light[2] / sight.light[2]},
         equal_pose(sight.frame->camera, frame.camera)});
  return found;
}

}  // namespace tessera
