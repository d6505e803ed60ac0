// A folder of masks is listed once for each clip; no image is opened.
#include "ingest/layouts/mask_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "ingest/files/folders.h"
#include "ingest/images/image_names.h"
#include "ingest/images/image_paths.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/test_views.h"
#include "kernels/base/counted.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// The camera, in lower case, and the number in the name of a mask: "cam00_00012.jpg.png".
std::optional<NumberedName> mask_name(const fs::path& file) {
  fs::path stem = file.stem();
  if (is_image_name(stem)) stem = stem.stem();
  auto name = parse_stem(stem.string());
  if (name) name->camera = lower_case(name->camera);
  return name;
}

fs::path subfolder(const fs::path& folder, const std::string& name) {
  return find_entry(folder, name, fs::file_type::directory);
}

/// The first of the places for the masks of a camera that holds images.
fs::path folder_of_masks(const fs::path& folder, const std::string& camera) {
  const auto inner = [](const fs::path& outer, const std::string& name) {
    return outer.empty() ? fs::path() : subfolder(outer, name);
  };
  const fs::path direct = subfolder(folder, camera);
  for (const fs::path& place :
       {direct, inner(direct, "masks"), inner(subfolder(folder, "masks"), camera)})
    if (!place.empty() && !images_in(place).empty()) return place;
  return {};
}

}  // namespace

fs::path MaskFiles::of_image(const std::string& image) {
  if (image.empty()) return {};
  fs::path found = index_.find(image + ".png");
  return found.empty() ? index_.find(fs::path(image).replace_extension().string()) : found;
}

MaskFiles::Series MaskFiles::series_of(const std::string& camera, bool alone) {
  std::map<std::string, Numbered> by_prefix;
  const auto read = [&](const fs::path& place) {
    by_prefix.clear();
    for (const fs::path& file : images_in(place))
      if (const auto name = mask_name(file)) by_prefix[name->camera].emplace(name->number, file);
  };
  if (const fs::path place = folder_of_masks(folder_, camera); !place.empty()) {
    read(place);
    if (by_prefix.size() > 1)
      warnings_.push_back(fmt::format(
          "{}: has masks with names of several kinds ({} and {}), of which the most frequent is "
          "read; keep one mask a frame there",
          place.string(), by_prefix.begin()->second.begin()->second.filename().string(),
          std::next(by_prefix.begin())->second.begin()->second.filename().string()));
    const auto most = std::max_element(
        by_prefix.begin(), by_prefix.end(),
        [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    if (most != by_prefix.end()) return {place, most->second};
    return {place, {}};
  }
  read(folder_);
  const auto named = by_prefix.find(lower_case(camera));
  if (named != by_prefix.end()) return {folder_ / camera, named->second};
  if (const auto plain = by_prefix.find(""); alone && plain != by_prefix.end())
    return {folder_, plain->second};
  return {};
}

int64_t MaskFiles::first_number(const RigClip& clip, const Series& series) {
  const auto frames = int64_t(clip.timeline.ticks.size());
  const int64_t first = series.masks.begin()->first, last = series.masks.rbegin()->first;
  if (first != 1 || last != frames || int64_t(series.masks.size()) != frames) return 0;
  counted_from_1_.push_back(clip.name);
  return 1;
}

void MaskFiles::note_count(const RigClip& clip, const Series& series, int64_t first) {
  const size_t masks = series.masks.size(), frames = clip.timeline.ticks.size();
  const int64_t last = series.masks.rbegin()->first;
  if (masks == frames && last < first + int64_t(frames)) return;
  const int64_t beyond =
      std::distance(series.masks.lower_bound(int64_t(frames)), series.masks.end());
  warnings_.push_back(fmt::format(
      "{} has {}, numbers {} to {}, the clip {}: number N is taken for frame N counted from 0, {}",
      series.place.string(), counted(masks, "mask"), series.masks.begin()->first, last,
      counted(frames, "frame"),
      beyond > 0 ? fmt::format("{} of them beyond its end", beyond) : "the others count whole"));
}

std::vector<fs::path> MaskFiles::of_clip(const RigClip& clip, bool alone) {
  const size_t frames = clip.timeline.ticks.size();
  std::vector<fs::path> files(frames, index_.find(clip.name));
  const Series series = series_of(clip.name, alone);
  if (series.masks.empty()) return files;
  std::set<int64_t> numbers;  // of the clip's images
  for (const NumberedImage& image : clip.images) numbers.insert(image.number);
  const bool by_image = std::all_of(series.masks.begin(), series.masks.end(),
                                    [&](const auto& mask) { return numbers.contains(mask.first); });
  const int64_t first = by_image ? 0 : first_number(clip, series);
  for (size_t i = 0; i < frames; ++i) {
    const auto found = series.masks.find(by_image ? clip.timeline.ticks[i] : first + int64_t(i));
    if (found != series.masks.end()) files[i] = found->second;
  }
  if (!by_image) note_count(clip, series, first);
  return files;
}

std::vector<std::string> MaskFiles::warnings() const {
  std::vector<std::string> lines = warnings_;
  for (std::string& line : index_.lines()) lines.push_back(std::move(line));
  if (const std::vector<fs::path> videos = videos_in(folder_); !videos.empty())
    lines.push_back(fmt::format(
        "{}: {} not read, because masks are images; to use them: `ffmpeg -i {} -start_number 0 "
        "{}/%05d.png`, in a folder for each camera",
        folder_.string(),
        videos.size() == 1 ? "1 video is" : counted(videos.size(), "video") + " are",
        videos.front().filename().string(), videos.front().stem().string()));
  return lines;
}

std::vector<std::string> MaskFiles::notes() const {
  if (counted_from_1_.empty()) return {};
  return {fmt::format("{}: masks of {} are numbered from 1; number 1 is that of the first frame",
                      folder_.string(), listed_names(counted_from_1_))};
}

std::string contents_of_masks(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code unreachable;
  for (const auto& entry : fs::directory_iterator(folder, unreachable)) {
    std::error_code unresolved;
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.')) continue;
    names.push_back(
        entry.is_directory(unresolved)
            ? fmt::format("{} ({})", name, counted(images_in(entry.path()).size(), "image"))
            : name);
  }
  std::sort(names.begin(), names.end());
  return names.empty() ? "nothing" : listed_names(names);
}

}  // namespace tessera
