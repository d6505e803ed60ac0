// Groups files by the cameras in their names, and rates how much the groups resemble a rig.
#include "ingest/layouts/image_sequences.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>

#include "ingest/calibration/model_photos.h"
#include "ingest/images/image_names.h"
#include "ingest/images/image_paths.h"
#include "ingest/layouts/camera_folders.h"
#include "ingest/layouts/name_times.h"
#include "ingest/prepared/transforms_json.h"
#include "ingest/test_views.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

struct NamedSequences {
  std::map<std::string, ImageSequence> cameras;
  std::vector<fs::path> unread;  // not numbered, or with a number of another file
};

/// How many images have each extension: of two with one number that of the commoner one is read.
std::map<std::string, size_t> images_of_extension(const std::vector<fs::path>& images) {
  std::map<std::string, size_t> counts;
  for (const fs::path& file : images) ++counts[file.extension().string()];
  return counts;
}

/// The images by camera.
NamedSequences named_sequences(const fs::path& folder) {
  NamedSequences found;
  const std::vector<fs::path> images = images_in(folder);
  std::map<std::string, size_t> like = images_of_extension(images);
  for (const fs::path& file : images) {
    const auto name = parse_stem(file.stem().string());
    if (!name) {
      found.unread.push_back(file);
      continue;
    }
    ImageSequence& camera = found.cameras[name->camera];
    camera.camera = name->camera;
    camera.path = folder / name->camera;
    camera.images.push_back({name->number, file});
  }
  for (auto& [name, camera] : found.cameras) {
    std::stable_sort(camera.images.begin(), camera.images.end(),
                     [&](const NumberedImage& a, const NumberedImage& b) {
                       return a.number != b.number ? a.number < b.number
                                                   : like[a.file.extension().string()] >
                                                         like[b.file.extension().string()];
                     });
    const auto again = [](const NumberedImage& a, const NumberedImage& b) {
      return a.number == b.number;
    };
    std::vector<NumberedImage> once;
    std::unique_copy(camera.images.begin(), camera.images.end(), std::back_inserter(once), again);
    for (size_t i = 1; i < camera.images.size(); ++i)
      if (again(camera.images[i - 1], camera.images[i]))
        found.unread.push_back(camera.images[i].file);
    camera.images = std::move(once);
  }
  return found;
}

/// The same; nothing where a file does not fit.
std::map<std::string, ImageSequence> sequences_by_name(const fs::path& folder) {
  NamedSequences found = named_sequences(folder);
  return found.unread.empty() ? std::move(found.cameras) : std::map<std::string, ImageSequence>{};
}

/// A folder with poses is a capture, not a camera of one.
bool is_posed_capture(const fs::path& folder) {
  return has_transforms(folder) || fs::exists(folder / "sparse") ||
         fs::exists(folder / "poses_bounds.npy");
}

bool is_called_camera(const ImageSequence& sequence) {
  return is_camera_name(sequence.camera);
}

/// The sub-folders that hold one sequence each, but for a few other files; only those named as
/// cameras where two are.
std::vector<ImageSequence> sequences_by_folder(const fs::path& folder) {
  std::vector<ImageSequence> cameras;
  for (const fs::path& candidate : folders_in(folder)) {
    const bool is_photo_set = candidate.filename().string().starts_with("images");
    if (is_photo_set || is_posed_capture(candidate)) continue;
    const fs::path place = images_of_camera(candidate);
    if (place.empty()) continue;
    NamedSequences found = named_sequences(place);
    if (found.cameras.size() != 1) continue;
    ImageSequence& first = found.cameras.begin()->second;
    if (found.unread.size() >= first.images.size()) continue;
    ImageSequence& camera = cameras.emplace_back(std::move(first));
    camera.camera = candidate.filename().string();
    camera.path = candidate;
    camera.unread = std::move(found.unread);
  }
  std::sort(cameras.begin(), cameras.end(),
            [](const ImageSequence& a, const ImageSequence& b) { return a.camera < b.camera; });
  return cameras;
}

/// Whether the sequence has a number at most `near` away.
bool has_number(const ImageSequence& sequence, int64_t number, int64_t near) {
  const auto found = std::lower_bound(
      sequence.images.begin(), sequence.images.end(), number - near,
      [](const NumberedImage& image, int64_t wanted) { return image.number < wanted; });
  return found != sequence.images.end() && found->number <= number + near;
}

/// How far numbers of one timestep may lie apart: of times half a frame.
int64_t nearness_of(const std::vector<ImageSequence>& cameras) {
  return seconds_of_names(cameras) ? median_step(cameras) / 2 : 0;
}

/// The numbers that all sequences have.
size_t common_numbers(const std::vector<ImageSequence>& cameras) {
  const int64_t near = nearness_of(cameras);
  return size_t(std::count_if(cameras.front().images.begin(), cameras.front().images.end(),
                              [&](const NumberedImage& image) {
                                return std::all_of(cameras.begin(), cameras.end(),
                                                   [&](const ImageSequence& camera) {
                                                     return has_number(camera, image.number, near);
                                                   });
                              }));
}

/// The most images of a sequence.
size_t longest(const std::vector<ImageSequence>& cameras) {
  size_t most = 0;
  for (const ImageSequence& camera : cameras) most = std::max(most, camera.images.size());
  return most;
}

/// Whether nine tenths of the numbers are of all sequences.
bool is_alike(const std::vector<ImageSequence>& cameras) {
  const size_t common = common_numbers(cameras);
  return common > 1 && 10 * common >= 9 * longest(cameras);
}

/// Whether the sequences are alike without a few, a quarter at most but one: a camera that failed
/// early does not make a rig anything else.
bool is_alike_but_few(std::vector<ImageSequence> cameras) {
  if (cameras.size() < 3) return false;
  std::stable_sort(cameras.begin(), cameras.end(),
                   [](const ImageSequence& a, const ImageSequence& b) {
                     return a.images.size() > b.images.size();
                   });
  cameras.resize(cameras.size() - std::max<size_t>(1, cameras.size() / 4));
  return is_alike(cameras);
}

/// Keeps those that are named as cameras where two are; `others`: the folders of those that go
/// although their numbers are the cameras'.
void keep_cameras(std::vector<ImageSequence>& sequences, std::vector<fs::path>& others) {
  if (std::count_if(sequences.begin(), sequences.end(), is_called_camera) < 2) return;
  const auto first_other =
      std::stable_partition(sequences.begin(), sequences.end(), is_called_camera);
  const std::vector<ImageSequence> cameras(sequences.begin(), first_other);
  for (auto other = first_other; other != sequences.end(); ++other)
    if (is_alike({cameras.front(), *other})) others.push_back(other->path);
  sequences.erase(first_other, sequences.end());
}

ImageSequences judged(std::vector<ImageSequence> cameras, bool in_folders) {
  constexpr size_t kTelling = 8;  // equal numbers in names that are no cameras'; brackets are fewer
  ImageSequences found{std::move(cameras), RigEvidence::kNone, "", in_folders};
  if (found.cameras.size() < 2) return found;
  const size_t common = common_numbers(found.cameras);
  bool named = true;
  std::vector<std::string> names;
  for (const ImageSequence& camera : found.cameras) {
    named = named && is_camera_name(camera.camera);
    names.push_back(camera.camera);
  }
  found.seen = fmt::format("{} {} ({}), {} numbers in all of them", names.size(),
                           in_folders ? "folders of numbered images" : "series of numbered images",
                           listed_names(names), common);
  const bool alike = is_alike(found.cameras);
  take_times(found);
  if (named && (alike || is_alike_but_few(found.cameras)))
    found.evidence = RigEvidence::kRig;
  else if ((named && common > 1) || (alike && common >= (in_folders ? 2 : kTelling)))
    found.evidence = RigEvidence::kUnclear;
  return found;
}

}  // namespace

ImageSequences find_image_sequences(const fs::path& capture) {
  for (const fs::path& folder : {capture, capture / "images"}) {
    if (!fs::is_directory(folder) || images_in(folder).empty()) continue;
    std::vector<ImageSequence> cameras;
    NamedSequences named = named_sequences(folder);
    for (auto& [name, camera] : named.cameras) cameras.push_back(std::move(camera));
    const bool is_rig =
        cameras.size() > 1 && std::all_of(cameras.begin(), cameras.end(), is_called_camera);
    if (!named.unread.empty() && !is_rig) return {};
    ImageSequences found = judged(std::move(cameras), false);
    found.unread = std::move(named.unread);
    return found;
  }
  const std::vector<fs::path> photos = photo_folders(capture);
  if (std::any_of(photos.begin(), photos.end(), [](const fs::path& folder) {
        return folder.filename().string().starts_with("images") && !images_in(folder).empty();
      }))
    return {};  // images_4 and the like: a photo set
  ImageSequences best;
  size_t rigs = 0;  // in folders of other names
  for (const fs::path& folder : parents_of_cameras(capture)) {
    if (best.evidence == RigEvidence::kRig && rigs == 0) break;
    const bool is_below = folder != capture && folder != capture / "images";
    if (is_below && is_posed_capture(folder)) continue;
    std::vector<ImageSequence> cameras = sequences_by_folder(folder);
    std::vector<fs::path> others;
    keep_cameras(cameras, others);
    ImageSequences found = judged(std::move(cameras), true);
    found.unread = std::move(others);
    if (is_below && found.evidence != RigEvidence::kRig) continue;
    if (is_below) ++rigs;
    if (found.evidence > best.evidence || best.cameras.empty()) best = std::move(found);
  }
  if (best.evidence == RigEvidence::kRig) return rigs > 1 ? ImageSequences{} : best;
  ImageSequences by_time = judged(sequences_of_timesteps(capture), true);
  return by_time.evidence == RigEvidence::kRig ? by_time : best;
}

std::string reading_text(size_t cameras, const std::string& times, double rate) {
  return fmt::format(
      "numbered images are read as those of {}, {} (pass --layout photos if they are photos of a "
      "scene that stands still)",
      cameras == 1 ? "one camera that moves"
                   : fmt::format("{} cameras that film together", cameras),
      times.empty() ? fmt::format("number N at N / {} s: --fps changes the rate", rate)
                    : "whose numbers are " + times);
}

ImageSequence single_sequence(const fs::path& folder) {
  auto sequences = sequences_by_name(folder);
  if (sequences.size() == 1) {
    ImageSequence all = std::move(sequences.begin()->second);
    all.camera = folder.filename().string();
    all.path = folder;
    return all;
  }
  ImageSequence all{folder.filename().string(), folder, {}};
  for (const fs::path& file : images_in(folder))
    all.images.push_back({int64_t(all.images.size()), file});
  return all;
}

bool looks_like_video(const fs::path& folder) {
  constexpr int64_t kLeast = 20;
  const auto sequences = sequences_by_name(folder);
  if (sequences.size() != 1) return false;
  const std::vector<NumberedImage>& images = sequences.begin()->second.images;
  const int64_t first = images.front().number, count = int64_t(images.size());
  return first <= 1 && count >= kLeast && images.back().number == first + count - 1;
}

}  // namespace tessera
