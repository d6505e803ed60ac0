// Medians over time of the images of a camera, and what differs from them.
#include "recon4d/evaluation/dynamic_regions.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "kernels/base/byte_medians.h"
#include "kernels/base/errors.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

/// At most kMoments, spread over time; none where there are too few or the camera moves.
std::vector<const Frame*> frames_of_median(std::vector<const Frame*> frames) {
  static_assert(DynamicRegions::kMoments <= kMostOfByteMedian);
  std::stable_sort(frames.begin(), frames.end(),
                   [](const Frame* a, const Frame* b) { return a->time < b->time; });
  const size_t count = std::min(frames.size(), DynamicRegions::kMoments);
  std::vector<const Frame*> chosen;
  if (count < DynamicRegions::kLeastMoments) return chosen;
  for (const Frame* frame : frames)
    if (!(frame->camera == frames.front()->camera)) return chosen;
  for (size_t i = 0; i < count; ++i)
    chosen.push_back(
        frames[size_t(even_spread(int64_t(i), int64_t(count), int64_t(frames.size())))]);
  return chosen;
}

/// What stands still in the images of a frame's camera over a longer clip; null: not known.
const Frame* still_of(const Scene& scene, const Frame& frame) {
  for (const Frame& still : scene.stills)
    if (still.camera_name == frame.camera_name && still.camera == frame.camera) return &still;
  return nullptr;
}

}  // namespace

DynamicRegions::DynamicRegions(const Scene& scene, Of of, const std::vector<int>& frames) {
  std::map<std::string, std::vector<const Frame*>> cameras;
  for (const int place : frames) cameras[scene.frames[size_t(place)].camera_name];
  for (const Frame& frame : scene.frames) {
    const auto camera = cameras.find(frame.camera_name);
    if (camera == cameras.end()) continue;
    if (of == Of::kAllFrames || frame.split == Split::kTrain) camera->second.push_back(&frame);
  }
  for (const auto& [name, of_camera] : cameras) {
    const std::vector<const Frame*> chosen = frames_of_median(of_camera);
    StillCamera& camera = cameras_[name];
    std::vector<uint8_t>& median = camera.median;
    if (chosen.empty()) continue;
    std::vector<const std::vector<uint8_t>*> images;
    for (const Frame* frame : chosen) images.push_back(&frame->image.data);
    if (const Frame* still = still_of(scene, *chosen.front())) {
      median = still->image.data;
      camera.mask = still->mask;
    } else {
      median = lower_medians(images);
    }
    camera.threshold = still_limit(images, median);
  }
}

std::vector<uint8_t> DynamicRegions::mask_of(const Frame& frame) const {
  const auto found = cameras_.find(frame.camera_name);
  check(found != cameras_.end(), "DynamicRegions: a camera that was not asked for");
  const std::vector<uint8_t>& median = found->second.median;
  std::vector<uint8_t> moves(median.size() / 3, 0);
  const std::vector<uint8_t>& still = found->second.mask.data();
  const auto differs = [&, most = found->second.threshold](size_t i) {
    return std::abs(int(frame.image.data[i]) - int(median[i])) > most;
  };
  for (size_t p = 0; p < moves.size(); ++p) {
    const bool is_known = still.empty() || still[p] != 0;
    const bool moves_here = !is_known || differs(3 * p) || differs(3 * p + 1) || differs(3 * p + 2);
    moves[p] = moves_here ? 255 : 0;
  }
  return moves;
}

}  // namespace tessera
