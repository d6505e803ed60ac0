// The timesteps are those of a reference camera; every frame belongs to the nearest of them.
#include "ingest/clocks/timesteps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "kernels/base/errors.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

using Times = std::set<double>;

Times reference_times(const std::vector<FrameTime>& frames) {
  std::map<std::string, Times> cameras;
  Times all, most;
  for (const FrameTime& frame : frames) {
    cameras[frame.camera].insert(frame.time);
    all.insert(frame.time);
  }
  for (const auto& [name, times] : cameras)
    if (times.size() > most.size()) most = times;
  return most.size() > 1 ? most : all;
}

double smallest_gap(const std::vector<double>& times) {
  double gap = INFINITY;
  for (size_t i = 1; i < times.size(); ++i) gap = std::min(gap, times[i] - times[i - 1]);
  return gap;
}

}  // namespace

std::vector<Timestep> group_timesteps(const std::vector<FrameTime>& frames) {
  const Times reference = reference_times(frames);
  const std::vector<double> times(reference.begin(), reference.end());
  std::vector<Timestep> timesteps;
  for (double time : times) timesteps.push_back({time, {}});
  const double reach = 0.5 * smallest_gap(times);
  for (const FrameTime& frame : frames) {
    const auto above =
        size_t(std::lower_bound(times.begin(), times.end(), frame.time) - times.begin());
    size_t nearest = std::min(above, times.size() - 1);
    if (above > 0 && frame.time - times[above - 1] < std::abs(times[nearest] - frame.time))
      nearest = above - 1;
    if (std::abs(times[nearest] - frame.time) <= reach)
      timesteps[nearest].frames.push_back(frame.index);
  }
  return timesteps;
}

std::vector<int64_t> key_timesteps(int64_t timesteps, int64_t most) {
  constexpr int64_t kApart = 10, kFewest = 8, kMost = 16;
  const int64_t last = timesteps - 1;
  const int64_t wished = std::clamp(1 + (last + kApart - 1) / kApart, kFewest, kMost);
  const int64_t count = std::min({wished, most, timesteps});
  std::vector<int64_t> chosen;
  for (int64_t i = 0; i < count; ++i) chosen.push_back(even_spread(i, count, timesteps));
  return chosen;
}

std::vector<int64_t> motion_timesteps(int64_t timesteps) {
  constexpr int64_t kApart = 2, kMost = 48;
  const int64_t last = timesteps - 1;
  const int64_t apart = std::max(kApart, (last + kMost - 2) / (kMost - 1));
  std::vector<int64_t> chosen;
  for (int64_t number = 0; number < last; number += apart) chosen.push_back(number);
  if (timesteps > 0) chosen.push_back(last);
  return chosen;
}

std::vector<Timestep> training_timesteps(const Scene& scene) {
  std::vector<FrameTime> times;
  for (int i : scene.split_indices(Split::kTrain)) {
    const Frame& frame = scene.frames[size_t(i)];
    times.push_back({frame.camera_name, frame.time, i});
  }
  return group_timesteps(times);
}

NormalisedTimes normalise_times(const std::vector<double>& source_times, bool allow_static,
                                const std::string& where) {
  check(!source_times.empty(), "normalise_times of nothing");
  const auto [least, most] = std::minmax_element(source_times.begin(), source_times.end());
  NormalisedTimes result;
  result.axis.origin = *least;
  result.time.assign(source_times.size(), 0.0);
  if (*least == *most) {
    if (source_times.size() > 1 && !allow_static)
      throw InputError(fmt::format(
          "{}: all {} frames have time {}; pass --static to reconstruct one timestep, or correct "
          "the times",
          where, source_times.size(), *least));
    result.is_static = true;
    return result;
  }
  result.axis.duration = *most - *least;
  for (size_t i = 0; i < source_times.size(); ++i)
    result.time[i] = (source_times[i] - *least) / result.axis.duration;
  return result;
}

}  // namespace tessera
