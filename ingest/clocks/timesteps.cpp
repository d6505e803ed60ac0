// The timesteps are those of a reference camera; the frames of the others belong to the nearest.
#include "ingest/clocks/timesteps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "ingest/clocks/frame_rates.h"
#include "kernels/base/errors.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

constexpr double kEqual = 1e-6;  // of the clip: closer times are one; clips have fewer frames

/// A time of a camera with its frames: several where one name stands for several cameras.
struct TimedFrames {
  double time = 0;
  std::vector<int> frames;
  bool trains = false;
};

struct Group {
  double time = 0;
  std::vector<int> frames;
};

using CameraClock = std::vector<TimedFrames>;  // ascending

/// Neighbours in time that are equal become one.
CameraClock merged(CameraClock clock) {
  std::stable_sort(clock.begin(), clock.end(),
                   [](const TimedFrames& a, const TimedFrames& b) { return a.time < b.time; });
  CameraClock kept;
  for (TimedFrames& timed : clock) {
    if (kept.empty() || timed.time - kept.back().time > kEqual) {
      kept.push_back(std::move(timed));
      continue;
    }
    kept.back().frames.insert(kept.back().frames.end(), timed.frames.begin(), timed.frames.end());
    kept.back().trains = kept.back().trains || timed.trains;
  }
  return kept;
}

/// By camera, in the order of names.
std::vector<CameraClock> camera_clocks(const std::vector<FrameTime>& frames) {
  std::map<std::string, CameraClock> cameras;
  for (size_t i = 0; i < frames.size(); ++i) {
    const bool trains = frames[i].split == Split::kTrain || frames[i].split == Split::kValidation;
    cameras[frames[i].camera].push_back({frames[i].time, {int(i)}, trains});
  }
  std::vector<CameraClock> list;
  for (auto& [name, clock] : cameras) list.push_back(merged(std::move(clock)));
  return list;
}

bool has_training(const CameraClock& camera) {
  return std::any_of(camera.begin(), camera.end(), [](const TimedFrames& m) { return m.trains; });
}

/// Whether clocks may differ: several training cameras with several times.
bool is_rig(const std::vector<CameraClock>& cameras) {
  return std::count_if(cameras.begin(), cameras.end(), [](const CameraClock& camera) {
           return has_training(camera) && camera.size() > 1;
         }) > 1;
}

std::vector<double> times_of(const CameraClock& camera) {
  std::vector<double> times;
  for (const TimedFrames& timed : camera) times.push_back(timed.time);
  return times;
}

/// 0 of one time.
double median_gap(const std::vector<double>& times) {
  std::vector<double> gaps;
  for (size_t i = 1; i < times.size(); ++i) gaps.push_back(times[i] - times[i - 1]);
  return gaps.empty() ? 0 : lower_median(std::move(gaps));
}

/// Ascending times of the camera with the rate that most have and, of these, with the most times;
/// of all cameras where none has two.
std::vector<double> reference_times(const std::vector<CameraClock>& cameras) {
  const bool any_trains = std::any_of(cameras.begin(), cameras.end(), has_training);
  std::vector<const CameraClock*> candidates;
  std::vector<double> gaps;
  CameraClock all;
  for (const CameraClock& camera : cameras) {
    all.insert(all.end(), camera.begin(), camera.end());
    if (any_trains && !has_training(camera)) continue;
    candidates.push_back(&camera);
    gaps.push_back(median_gap(times_of(camera)));
  }
  std::pair<int64_t, size_t> most{-1, 0};  // cameras of one rate, times
  const CameraClock* reference = nullptr;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const std::pair rank{cameras_of_rate(gaps[i], gaps), candidates[i]->size()};
    if (rank <= most) continue;
    most = rank;
    reference = candidates[i];
  }
  return times_of(reference->size() > 1 ? *reference : merged(std::move(all)));
}

/// The place of the time within `reach` that is nearest, the earlier of two: what lies half a gap
/// before the first belongs to none, as its like further on do to the time before.
std::optional<size_t> nearest(const std::vector<double>& times, double reach, double time) {
  const auto above = size_t(std::lower_bound(times.begin(), times.end(), time) - times.begin());
  const double after = above < times.size() ? times[above] - time : INFINITY;
  const double before = above > 0 ? time - times[above - 1] : INFINITY;
  if (before <= std::min(after, reach) + kEqual) return above - 1;
  if (after <= std::max(reach - kEqual, kEqual)) return above;
  return std::nullopt;
}

/// Moves the frames of one camera that are near one of `times` into `groups`, those of training
/// first; one timed of the camera for each.
void join(const std::vector<double>& times, double reach, CameraClock& camera,
          std::vector<Group>& groups) {
  std::map<size_t, TimedFrames*> taken;
  const auto apart = [&](const TimedFrames& timed, size_t k) {
    return std::abs(times[k] - timed.time);
  };
  for (TimedFrames& timed : camera) {
    const std::optional<size_t> k = nearest(times, reach, timed.time);
    if (!k) continue;
    TimedFrames*& place = taken[*k];
    const bool better =
        place == nullptr || timed.trains > place->trains ||
        (timed.trains == place->trains && apart(timed, *k) + kEqual < apart(*place, *k));
    if (better) place = &timed;
  }
  for (auto& [k, timed] : taken) {
    std::vector<int>& frames = groups[k].frames;
    frames.insert(frames.end(), timed->frames.begin(), timed->frames.end());
    timed->frames.clear();
  }
  std::erase_if(camera, [](const TimedFrames& timed) { return timed.frames.empty(); });
}

/// All frames, ascending in time.
std::vector<Group> group_clocks(std::vector<CameraClock> cameras) {
  std::vector<Group> groups;
  double reach = is_rig(cameras) ? INFINITY : 0;
  while (!cameras.empty()) {
    const std::vector<double> times = reference_times(cameras);
    if (const double gap = median_gap(times); gap > 0) reach = std::min(reach, 0.5 * gap);
    std::vector<Group> found;
    for (double time : times) found.push_back({time, {}});
    for (CameraClock& camera : cameras) join(times, reach, camera, found);
    groups.insert(groups.end(), found.begin(), found.end());
    std::erase_if(cameras, [](const CameraClock& camera) { return camera.empty(); });
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const Group& a, const Group& b) { return a.time < b.time; });
  return groups;
}

}  // namespace

std::vector<int64_t> timestep_numbers(const std::vector<FrameTime>& frames) {
  std::vector<int64_t> numbers(frames.size(), 0);
  int64_t number = 0;
  for (const Group& group : group_clocks(camera_clocks(frames))) {
    for (const int i : group.frames) numbers[size_t(i)] = number;
    ++number;
  }
  return numbers;
}

void number_timesteps(Scene& scene) {
  std::vector<FrameTime> frames;
  for (const Frame& frame : scene.frames)
    frames.push_back({frame.camera_name, frame.time, frame.split});
  const std::vector<int64_t> numbers = timestep_numbers(frames);
  for (size_t i = 0; i < numbers.size(); ++i) scene.frames[i].timestep = numbers[i];
}

std::vector<Timestep> training_timesteps(const Scene& scene) {
  std::map<int64_t, Timestep> found;
  for (int i : scene.split_indices(Split::kTrain))
    found[scene.frames[size_t(i)].timestep].frames.push_back(i);
  std::vector<Timestep> timesteps;
  for (auto& [number, timestep] : found) {
    std::vector<double> times;
    for (int i : timestep.frames) times.push_back(scene.frames[size_t(i)].time);
    timesteps.push_back({number, lower_median(std::move(times)), std::move(timestep.frames)});
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
