// Files are read whole only where others have their sizes and begin alike. Frames are compared byte
// for byte: noise tells a still scene from a frozen input.
#include "ingest/video/clip_mistakes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "ingest/files/fnv1a.h"
#include "ingest/test_views.h"
#include "ingest/video/clip_frames.h"
#include "kernels/base/counted.h"
#include "kernels/base/median.h"

namespace tessera {
namespace {

std::vector<uintmax_t> sizes_of(const RigClip& clip) {
  std::vector<uintmax_t> sizes;
  const auto add = [&](const std::filesystem::path& file) {
    std::error_code unreadable;
    sizes.push_back(std::filesystem::file_size(file, unreadable));
  };
  for (const NumberedImage& image : clip.images) add(image.file);
  if (clip.images.empty()) add(clip.video);
  for (const std::filesystem::path& chapter : clip.chapters) add(chapter);
  return sizes;
}

/// Of its first file: images without compression have one size in all cameras.
std::string sample_of(const RigClip& clip) {
  return sampled_hash(clip.images.empty() ? clip.video : clip.images.front().file);
}

using Clips = std::vector<const RigClip*>;

/// Those that share what `key` says of them with another one, in groups.
template <typename Key>
std::vector<Clips> alike(const Clips& clips, Key key) {
  std::map<decltype(key(*clips.front())), Clips> groups;
  for (const RigClip* clip : clips) groups[key(*clip)].push_back(clip);
  std::vector<Clips> several;
  for (auto& [value, group] : groups)
    if (group.size() > 1) several.push_back(std::move(group));
  return several;
}

/// Numbers by their distance from the first.
std::vector<int64_t> pattern_of(const RigClip& clip) {
  std::vector<int64_t> pattern = clip.timeline.ticks;
  for (int64_t& tick : pattern) tick -= clip.timeline.ticks.front();
  return pattern;
}

}  // namespace

std::vector<std::string> copied_clips(const std::vector<RigClip>& clips) {
  Clips all;
  for (const RigClip& clip : clips) all.push_back(&clip);
  std::vector<std::string> lines;
  for (const Clips& as_large : alike(all, sizes_of))
    for (const Clips& begin_alike : alike(as_large, sample_of))
      for (const Clips& copies : alike(begin_alike, clip_hash)) {
        std::vector<std::string> names;
        for (const RigClip* clip : copies) names.push_back(clip->name);
        lines.push_back(
            fmt::format("{} are one recording, byte for byte: replace the copies, or leave them "
                        "out with --cameras",
                        listed_names(names)));
      }
  return lines;
}

std::string shifted_numbers(const std::vector<RigClip>& clips) {
  std::map<std::vector<int64_t>, std::map<int64_t, std::vector<std::string>>> names;
  for (const RigClip& clip : clips)
    if (!clip.images.empty() && !clip.number_seconds)
      names[pattern_of(clip)][clip.timeline.ticks.front()].push_back(clip.name);
  for (const auto& [pattern, by_first] : names) {
    if (by_first.size() < 2 || pattern.size() < 2) continue;
    auto usual = by_first.begin();
    for (auto it = by_first.begin(); it != by_first.end(); ++it)
      if (it->second.size() > usual->second.size()) usual = it;
    for (const auto& [first, cameras] : by_first)
      if (first != usual->first)
        return fmt::format(
            "the images of {} are numbered from {}, as many of {} from {}: they count as taken {} "
            "{}; if they were taken together, number them alike or pass --offsets",
            listed_names(cameras), first, listed_names(usual->second), usual->first,
            counted(std::abs(first - usual->first), "number"),
            first > usual->first ? "later" : "earlier");
  }
  return "";
}

void FrozenFrames::see(const Image8& image, double seconds) {
  if (now_.frames == 0 || image.data != image_.data) {
    image_ = image;
    now_ = {longest_.camera, 0, seconds, seconds};
  }
  ++now_.frames;
  now_.last = seconds;
  if (now_.frames > longest_.frames) longest_ = now_;
}

std::vector<std::string> frozen_warnings(const std::vector<FrozenStretch>& cameras) {
  constexpr int64_t kFewest = 5, kTimes = 3;
  std::vector<int64_t> frames;
  for (const FrozenStretch& camera : cameras) frames.push_back(camera.frames);
  std::vector<std::string> lines;
  if (frames.size() < 2) return lines;
  const int64_t usual = lower_median(std::move(frames));
  for (const FrozenStretch& camera : cameras)
    if (camera.frames >= std::max(kFewest, kTimes * usual))
      lines.push_back(fmt::format(
          "camera {} repeats one image from {:.3f} s to {:.3f} s ({} frames), the others do "
          "not, so its input was lost; shorten the window with --start and --duration, or leave it "
          "out with "
          "--cameras",
          camera.camera, camera.first, camera.last, camera.frames));
  return lines;
}

}  // namespace tessera
