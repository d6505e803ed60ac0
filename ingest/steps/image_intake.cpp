// Records unreadable images by index, and removes their frames from the scene.
#include "ingest/steps/image_intake.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "ingest/images/image_source.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

void erase_cameras_without_frames(Capture& capture) {
  std::set<std::string> used;
  for (const CaptureFrame& frame : capture.frames) used.insert(frame.frame.camera_name);
  std::erase_if(capture.cameras,
                [&](const CaptureCamera& camera) { return !used.contains(camera.name); });
}

bool is_transparent(const Image8& image) {
  if (image.channels != 4) return false;
  for (size_t i = 3; i < image.data.size(); i += 4)
    if (image.data[i] != 0) return false;
  return true;
}

}  // namespace

/// "12 of Display P3, 3 of Adobe RGB"; "" where no image has one.
std::string ImageIntake::profiles_text(std::string Image::*name) const {
  std::map<std::string, int64_t> counts;
  for (const Image& image : images_)
    if (!(image.*name).empty()) ++counts[image.*name];
  std::string text;
  for (const auto& [profile, count] : counts)
    text += fmt::format("{}{} of {}", text.empty() ? "" : ", ", count, profile);
  return text;
}

std::optional<Image8> ImageIntake::read(size_t index, const std::filesystem::path& file, int width,
                                        int height) {
  Image& known = images_[index];
  try {
    SourceImage source = read_source_image(file);
    known.tone_mapped = source.tone_mapped;
    known.had_alpha = source.image.channels == 4;
    known.converted = source.converted;
    known.unconverted = source.unconverted;
    known.is_empty = is_transparent(source.image);
    if (width == 0 || height == 0) {
      width = source.image.width;
      height = source.image.height;
    }
    return image_as_posed(std::move(source), width, height, known.doubtful);
  } catch (const InputError& error) {
    known.unreadable = error.what();
    return std::nullopt;
  }
}

void ImageIntake::finish(bool strict, Capture& capture) const {
  std::vector<std::string> reasons, doubtful;
  std::vector<CaptureFrame> kept;
  int64_t empty = 0;
  for (size_t i = 0; i < images_.size(); ++i) {
    const Image& image = images_[i];
    CaptureFrame& frame = capture.frames[i];
    empty += image.is_empty;
    if (image.tone_mapped) capture.tone_map = kToneMap;
    if (image.had_alpha) capture.background = "alpha kept";
    if (image.doubtful) doubtful.push_back(frame.source.name);
    if (image.unreadable.empty())
      kept.push_back(std::move(frame));
    else
      reasons.push_back(image.unreadable);
  }
  if (!reasons.empty() && (strict || reasons.size() == images_.size()))
    throw InputError(fmt::format("{} ({} of {} images cannot be read{})", reasons.front(),
                                 reasons.size(), images_.size(),
                                 strict ? "; without --strict they are left out" : ""));
  for (const std::string& reason : reasons) capture.warnings.push_back("image left out: " + reason);
  if (!doubtful.empty())
    capture.warnings.push_back(fmt::format(
        "{} images have an EXIF rotation that their size does not tell from none; they are taken "
        "as stored, as COLMAP takes them: {}",
        doubtful.size(), listed_names(doubtful)));
  if (2 * empty > int64_t(images_.size()))
    throw InputError(fmt::format(
        "{}: {} of {} images are transparent throughout, so that nothing of them would count; "
        "write them without alpha, or with that of what is to be seen",
        capture.folder.string(), empty, images_.size()));
  if (empty > 0)
    capture.warnings.push_back(
        fmt::format("{}: {} images are transparent throughout", capture.folder.string(), empty));
  if (const std::string text = profiles_text(&Image::converted); !text.empty()) {
    capture.notes.push_back(fmt::format("{}: colours of images are converted to sRGB: {}",
                                        capture.folder.string(), text));
    if (capture.tone_map == "none") capture.tone_map = "ICC profile to sRGB";
  }
  if (const std::string text = profiles_text(&Image::unconverted); !text.empty())
    capture.warnings.push_back(
        fmt::format("{}: colour profiles of a kind that is not read, so that colours are taken as "
                    "sRGB: {}; convert these images to sRGB",
                    capture.folder.string(), text));
  capture.frames = std::move(kept);
  erase_cameras_without_frames(capture);
  if (std::none_of(capture.frames.begin(), capture.frames.end(),
                   [](const CaptureFrame& frame) { return frame.frame.split == Split::kTrain; }))
    throw InputError(fmt::format(
        "{} (no image of the split 'train' is left; restore some of them, or hold fewer out)",
        reasons.empty() ? "all images are held out" : reasons.front()));
}

}  // namespace tessera
