// Assignment of training frames to sweeps and series, in the order of their timesteps.
#include "recon4d/evaluation/frame_sample.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Of `bits` bits.
int64_t reversed(int64_t value, int bits) {
  int64_t result = 0;
  for (int i = 0; i < bits; ++i) result |= (value >> i & 1) << (bits - 1 - i);
  return result;
}

/// Where a training frame is drawn.
struct Place {
  int64_t sweep, series, timestep;
  int frame;  // in the scene

  bool operator<(const Place& b) const {
    return std::tie(sweep, series, timestep, frame) <
           std::tie(b.sweep, b.series, b.timestep, b.frame);
  }
};

}  // namespace

int64_t FrameSample::at_once() const {
  constexpr int64_t kPixels = int64_t{1} << 22, kLeast = 4, kMost = 16;
  int64_t largest = 1;
  for (int64_t i = 0; i < count(); ++i)
    largest = std::max(largest, int64_t(frame(i).camera.width) * frame(i).camera.height);
  return std::clamp(kPixels / largest, kLeast, kMost);
}

FrameSample sample_training_frames(const Scene& scene, int64_t least_frames) {
  std::map<std::string, std::vector<int>> cameras;  // frames of each, by time
  std::set<int64_t> numbers;                        // of the timesteps
  for (const int frame : scene.split_indices(Split::kTrain)) {
    const int64_t timestep = scene.frames[size_t(frame)].timestep;
    check(timestep >= 0, "sample_training_frames: timesteps have no numbers");
    cameras[scene.frames[size_t(frame)].camera_name].push_back(frame);
    numbers.insert(timestep);
  }
  int64_t count = 0, longest = 0;
  for (auto& [name, frames] : cameras) {
    std::stable_sort(frames.begin(), frames.end(), [&](int a, int b) {
      return scene.frames[size_t(a)].timestep < scene.frames[size_t(b)].timestep;
    });
    count += int64_t(frames.size());
    longest = std::max(longest, int64_t(frames.size()));
  }
  constexpr int64_t kLeastTimesteps = 3;  // of a series that shares the timesteps with others
  const bool is_rig = cameras.size() > 1 && longest > 1;
  int bits = 0;
  while ((count >> (bits + 1)) >= std::max<int64_t>(1, least_frames) &&
         (!is_rig || (longest >> (bits + 1)) >= kLeastTimesteps))
    ++bits;
  const int64_t sweeps = int64_t{1} << bits;
  // a sweep leaves gaps where there are fewer cameras than sweeps: the next ones fill them
  int gap_bits = bits;
  while (gap_bits > 0 && int64_t(cameras.size()) >> (bits - gap_bits + 1) > 0) --gap_bits;
  const int64_t gap = int64_t{1} << gap_bits;

  std::map<int64_t, int64_t> rank;  // of a timestep among those of training frames
  for (const int64_t number : numbers) rank.emplace(number, int64_t(rank.size()));
  std::vector<Place> places;
  int64_t camera = 0;
  for (const auto& [name, frames] : cameras) {
    const int64_t series = camera % sweeps, phase = reversed(series, bits);
    for (size_t i = 0; i < frames.size(); ++i) {
      const int64_t timestep = rank.at(scene.frames[size_t(frames[i])].timestep);
      // a frame that is missing must not shift a camera against the others of its series
      const int64_t shift = ((is_rig ? timestep : int64_t(i)) + phase) % sweeps;
      places.push_back(
          {shift / gap * gap + reversed(shift % gap, gap_bits), series, timestep, frames[i]});
    }
    ++camera;
  }
  std::sort(places.begin(), places.end());

  FrameSample sample;
  sample.scene = &scene;
  sample.sweeps.resize(size_t(sweeps));
  for (size_t i = 0; i < places.size(); ++i) {
    sample.frames.push_back(places[i].frame);
    FrameRange& sweep = sample.sweeps[size_t(places[i].sweep)];
    const bool begins = sweep.end == 0;
    if (begins) sweep.begin = int64_t(i);
    sweep.end = int64_t(i) + 1;
    const bool same = !begins && places[i].series == places[i - 1].series;
    sample.series.push_back(i == 0 ? 0 : sample.series.back() + (same ? 0 : 1));
  }
  return sample;
}

}  // namespace tessera
