// Records unreadable images by index, and removes their frames from the scene.
#include "ingest/layouts/image_intake.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "ingest/images/image_source.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

template <class T>
void erase_where(std::vector<T>& values, const std::vector<std::string>& reasons) {
  size_t kept = 0;
  for (size_t i = 0; i < values.size(); ++i)
    if (i >= reasons.size() || reasons[i].empty()) std::swap(values[kept++], values[i]);
  values.resize(kept);
}

void erase_cameras_without_frames(PreparedScene& scene) {
  std::set<std::string> used;
  for (const PreparedFrame& frame : scene.frames) used.insert(frame.frame.camera_name);
  std::erase_if(scene.cameras,
                [&](const PreparedCamera& camera) { return !used.contains(camera.name); });
}

}  // namespace

std::optional<Image8> ImageIntake::read(size_t index, const std::filesystem::path& file, int width,
                                        int height) {
  try {
    SourceImage source = read_source_image(file);
    if (source.tone_mapped) tone_mapped_ = true;
    if (source.image.channels == 4) had_alpha_ = true;
    if (width == 0 || height == 0) {
      width = source.image.width;
      height = source.image.height;
    }
    bool doubtful = false;
    Image8 image = image_as_posed(std::move(source), width, height, doubtful);
    doubtful_[index] = doubtful;
    return image;
  } catch (const InputError& error) {
    unreadable_[index] = error.what();
    return std::nullopt;
  }
}

void ImageIntake::finish(PreparedScene& scene, bool strict,
                         std::vector<std::string>& warnings) const {
  std::vector<std::string> reasons, doubtful;
  for (size_t i = 0; i < unreadable_.size(); ++i) {
    if (!unreadable_[i].empty()) reasons.push_back(unreadable_[i]);
    if (doubtful_[i]) doubtful.push_back(scene.sources[i].name);
  }
  if (!reasons.empty() && (strict || reasons.size() == unreadable_.size()))
    throw InputError(fmt::format("{} ({} of {} images cannot be read{})", reasons.front(),
                                 reasons.size(), unreadable_.size(),
                                 strict ? "; without --strict they are left out" : ""));
  for (const std::string& reason : reasons) warnings.push_back("image left out: " + reason);
  if (!doubtful.empty())
    warnings.push_back(fmt::format(
        "{} images have an EXIF rotation that their size does not tell from none; they are taken "
        "as stored, as COLMAP takes them: {}",
        doubtful.size(), listed_names(doubtful)));
  erase_where(scene.frames, unreadable_);
  erase_where(scene.sources, unreadable_);
  erase_cameras_without_frames(scene);
  if (std::none_of(scene.frames.begin(), scene.frames.end(),
                   [](const PreparedFrame& frame) { return frame.frame.split == Split::kTrain; }))
    throw InputError(fmt::format(
        "{} (no image of the split 'train' is left; restore some of them, or hold fewer out)",
        reasons.empty() ? "all images are held out" : reasons.front()));
  scene.background = had_alpha_ ? "alpha kept" : "opaque";
  if (tone_mapped_) scene.tone_map = kToneMap;
}

void note_missing(const std::filesystem::path& folder, const std::vector<std::string>& missing,
                  const std::string& owner, bool strict, std::vector<std::string>& warnings) {
  if (missing.empty()) return;
  const std::string seen = fmt::format("{}: {} photos of {} are missing: {}", folder.string(),
                                       missing.size(), owner, listed_names(missing));
  if (strict) throw InputError(seen + "; restore them, or leave --strict out to go on without");
  warnings.push_back(seen);
}

}  // namespace tessera
