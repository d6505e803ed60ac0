// Reads videos or sequences of images, one a camera, as clips; they are opened later.
#include <fmt/format.h>

#include <map>

#include "ingest/layouts/capture_layout.h"
#include "ingest/layouts/layout_readers.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

std::vector<RigClip> video_clips(const std::filesystem::path& folder) {
  std::map<std::string, VideoCamera> videos;
  for (VideoCamera& video : video_cameras(folder)) {
    const auto [first, is_new] = videos.emplace(video.name, video);
    if (!is_new)
      throw InputError(fmt::format(
          "{}: has the camera '{}' twice, as {} and {}; rename or remove one of them",
          folder.string(), first->first, first->second.files.front().filename().string(),
          video.files.front().filename().string()));
  }
  if (videos.empty())
    throw InputError(
        fmt::format("{}: has no videos; put one file per camera there", folder.string()));
  std::vector<RigClip> clips;
  for (auto& [name, video] : videos) {
    RigClip& clip = clips.emplace_back();
    clip.name = name;
    clip.video = video.files.front();
    clip.chapters.assign(video.files.begin() + 1, video.files.end());
  }
  return clips;
}

std::string names_of(const std::vector<std::filesystem::path>& files) {
  std::vector<std::string> names;
  for (const std::filesystem::path& file : files) names.push_back(file.filename().string());
  return listed_names(names);
}

/// Numbered images of several cameras, or of one that moves.
std::vector<RigClip> image_clips(const std::filesystem::path& folder, const IngestOptions& options,
                                 Capture& capture) {
  std::vector<RigClip> clips;
  std::vector<std::string>& warnings = capture.warnings;
  ImageSequences found = sequences_of(folder, options.image_layout);
  capture.notes.push_back(fmt::format(
      "{}: {}", folder.string(),
      reading_text(found.cameras.size(), found.times, options.image_rate.value_or(kImageRate))));
  const auto warn_of_images = [&](const std::string& where,
                                  const std::vector<std::filesystem::path>& files) {
    if (!files.empty())
      warnings.push_back(
          fmt::format("{}: not read, as their names have no number or that of another image: {}",
                      where, names_of(files)));
  };
  for (ImageSequence& sequence : found.cameras) {
    warn_of_images(sequence.path.string(), sequence.unread);
    clips.push_back(
        {sequence.camera, sequence.path, {}, {}, std::move(sequence.images), found.number_seconds});
  }
  if (!found.in_folders)
    warn_of_images(folder.string(), found.unread);
  else if (!found.unread.empty())
    warnings.push_back(fmt::format(
        "{}: not read, as they are not called like cameras (cam00), though their images "
        "have the cameras' numbers: {}",
        folder.string(), names_of(found.unread)));
  return clips;
}

}  // namespace

Capture read_clip_layout(const std::filesystem::path& folder, const IngestOptions& options) {
  const bool of_images = options.layout == CaptureLayout::kSequences;
  Capture capture;
  capture.folder = folder;
  capture.layout = of_images ? "sequences" : "videos";
  capture.clips = of_images ? image_clips(folder, options, capture) : video_clips(folder);
  for (const RigClip& clip : capture.clips)
    if (!clip.chapters.empty())
      capture.notes.push_back(fmt::format("{}: camera {} is {} chapters of one recording, {} to {}",
                                          folder.string(), clip.name, clip.chapters.size() + 1,
                                          clip.video.filename().string(),
                                          clip.chapters.back().filename().string()));
  capture.posed = false;
  capture.is_timed = true;
  capture.times_from = folder;
  return capture;
}

}  // namespace tessera
