// Leaves out cameras one after the other: of the one that begins last and the one that ends first
// the one whose absence gives more timesteps.
#include "ingest/clocks/limiting_cameras.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "kernels/base/errors.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

/// A set of cameras and what they share.
struct Shared {
  std::vector<size_t> members;  // places in the list of all cameras, increasing
  int64_t timesteps = 0;
  double length = 0;  // seconds; negative where the cameras share nothing
};

Shared shared_by(std::vector<size_t> members, const std::vector<std::vector<double>>& seconds,
                 const FrameWindow& window) {
  std::vector<std::vector<double>> clips;
  for (const size_t i : members) clips.push_back(seconds[i]);
  const TimeInterval common = common_interval(clips);
  std::vector<int64_t> counts;  // a camera of another rate or with gaps has its own number
  for (const std::vector<double>& clip : clips)
    counts.push_back(int64_t(choose_frames(clip, window, common).size()));
  return {std::move(members), lower_median(std::move(counts)), common.last - common.first};
}

/// The set without the camera that begins last, or without the one that ends first.
Shared one_left_out(const Shared& all, const std::vector<std::vector<double>>& seconds,
                    const FrameWindow& window) {
  const auto begins_last =
      std::max_element(all.members.begin(), all.members.end(),
                       [&](size_t a, size_t b) { return seconds[a].front() < seconds[b].front(); });
  const auto ends_first =
      std::min_element(all.members.begin(), all.members.end(),
                       [&](size_t a, size_t b) { return seconds[a].back() < seconds[b].back(); });
  const auto without = [&](std::vector<size_t>::const_iterator place) {
    std::vector<size_t> members = all.members;
    members.erase(members.begin() + (place - all.members.begin()));
    return shared_by(std::move(members), seconds, window);
  };
  Shared one = without(begins_last), other = without(ends_first);
  const bool first_is_better = one.timesteps != other.timesteps ? one.timesteps > other.timesteps
                                                                : one.length > other.length;
  return first_is_better ? one : other;
}

}  // namespace

LimitedClip limited_clip(const std::vector<std::string>& cameras,
                         const std::vector<std::vector<double>>& seconds,
                         const FrameWindow& window) {
  constexpr double kAsGood = 0.9;  // of the most: no more cameras are left out for the rest
  constexpr int64_t kFew = 2;      // timesteps: fewer are lost where clocks differ by a frame
  check(cameras.size() == seconds.size(), "limited_clip: times for each camera");
  if (cameras.size() < 3) return {};
  FrameWindow of_capture = window;
  of_capture.fps.reset();
  std::vector<size_t> members;
  for (size_t i = 0; i < cameras.size(); ++i) members.push_back(i);
  std::vector<Shared> sets{shared_by(std::move(members), seconds, of_capture)};
  int64_t most = sets.front().timesteps;
  for (size_t left_out = 0; left_out < std::max<size_t>(1, cameras.size() / 4); ++left_out) {
    sets.push_back(one_left_out(sets.back(), seconds, of_capture));
    most = std::max(most, sets.back().timesteps);
  }
  const auto best = std::find_if(sets.begin(), sets.end(), [&](const Shared& set) {
    return double(set.timesteps) >= kAsGood * double(most);
  });
  LimitedClip clip{{}, {}, sets.front().timesteps, best->timesteps};
  if (clip.without - clip.timesteps < kFew) return clip;
  for (size_t i = 0; i < cameras.size(); ++i) {
    const bool stays = std::binary_search(best->members.begin(), best->members.end(), i);
    (stays ? clip.others : clip.limiting).push_back(cameras[i]);
  }
  return clip;
}

std::string limit_warning(const LimitedClip& clip, const std::string& where) {
  if (clip.limiting.empty()) return "";
  const bool one = clip.limiting.size() == 1;
  const std::string seen =
      fmt::format("{} {} the clip to {} of {} timesteps", fmt::join(clip.limiting, ", "),
                  one ? "limits" : "limit", clip.timesteps, clip.without);
  const std::string gain =
      fmt::format("without {} there are {}", one ? "it" : "them", clip.without);
  if (2 * clip.timesteps >= clip.without) return seen + "; " + gain;
  const std::string keep =
      clip.timesteps == 0
          ? "; or state the clocks with --offsets"
          : fmt::format("; or pass --frames {} to use what all cameras have", clip.timesteps);
  throw InputError(fmt::format("{}: {}, less than half; {}: --cameras {}{}", where, seen, gain,
                               fmt::join(clip.others, ","), keep));
}

}  // namespace tessera
