// Intervals begin where a camera begins and end where one ends.
#include "ingest/clocks/shared_time.h"

#include <algorithm>

#include "kernels/base/errors.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

using Clips = std::vector<std::vector<double>>;

SharedTime films(const Clips& clips, size_t missing) {
  SharedTime shared{longest_interval(clips, missing), {}};
  for (const std::vector<double>& clip : clips)
    shared.films_all_of.push_back(clip.front() <= shared.interval.first &&
                                  clip.back() >= shared.interval.last);
  return shared;
}

/// Of a camera that films all of it: one of another rate or with gaps has its own number.
int64_t timesteps_of(const SharedTime& shared, const Clips& clips, FrameWindow window) {
  window.fps.reset();
  std::vector<int64_t> counts;
  for (size_t i = 0; i < clips.size(); ++i)
    if (shared.films_all_of[i])
      counts.push_back(int64_t(choose_frames(clips[i], window, shared.interval).size()));
  return counts.empty() ? 0 : lower_median(std::move(counts));
}

}  // namespace

TimeInterval longest_interval(const Clips& clips, size_t missing) {
  check(missing < clips.size(), "an interval has a camera");
  std::vector<double> begins, ends;
  for (const std::vector<double>& clip : clips) {
    check(!clip.empty(), "a clip has frames");
    begins.push_back(clip.front());
    ends.push_back(clip.back());
  }
  std::sort(begins.begin(), begins.end());
  std::sort(ends.begin(), ends.end());
  const auto begun = [&](double time) {
    return std::upper_bound(begins.begin(), begins.end(), time) - begins.begin();
  };
  const auto needed = std::ptrdiff_t(clips.size() - missing);
  TimeInterval longest{0, -1};
  for (const double first : begins) {
    auto end = std::lower_bound(ends.begin(), ends.end(), first);
    if (begun(first) - (end - ends.begin()) < needed) continue;
    while (begun(*end) - (std::upper_bound(end, ends.end(), *end) - ends.begin()) >= needed) ++end;
    if (*end - first > longest.last - longest.first) longest = {first, *end};
  }
  return longest;
}

SharedTime shared_time(const Clips& clips, const FrameWindow& window) {
  constexpr double kAsGood = 0.9;  // of the timesteps of most cameras
  constexpr int64_t kFew = 2;      // timesteps: fewer are lost where clocks differ by a frame
  SharedTime all = films(clips, 0);
  if (clips.size() < 3) return all;
  SharedTime most = films(clips, std::max<size_t>(1, clips.size() / 4));
  const int64_t by_all = timesteps_of(all, clips, window);
  const int64_t by_most = timesteps_of(most, clips, window);
  const bool is_won = double(by_all) < kAsGood * double(by_most) && by_most - by_all >= kFew;
  return is_won ? most : all;
}

}  // namespace tessera
