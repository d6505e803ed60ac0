// Keeps the lists of a capture of equal lengths, and its lenses and missing images named once.
#include "ingest/capture/capture.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/poses/far_origin.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {

void take_origin_out(Capture& capture) {
  std::vector<glm::dvec3> centres;
  for (const RigClip& clip : capture.clips) centres.push_back(clip.camera->camera.position());
  for (const CaptureFrame& frame : capture.frames) centres.push_back(frame.frame.camera.position());
  const Similarity change = less(far_origin(centres));
  for (RigClip& clip : capture.clips)
    clip.camera->camera = camera_in_world(change, clip.camera->camera);
  for (CaptureFrame& frame : capture.frames)
    frame.frame.camera = camera_in_world(change, frame.frame.camera);
  capture.origin -= change.translation;
  capture.prepared_from_source = compose(less(capture.origin), capture.prepared_from_source);
}

std::vector<std::string> clip_names(const Capture& capture) {
  std::vector<std::string> names;
  for (const RigClip& clip : capture.clips) names.push_back(clip.name);
  return names;
}

void keep_clips(Capture& capture, const std::vector<char>& keep) {
  check(keep.size() == capture.clips.size(), "keep_clips: one entry a clip");
  std::vector<RigClip> clips;
  std::vector<char> held_out;
  for (size_t i = 0; i < keep.size(); ++i) {
    if (!keep[i]) continue;
    clips.push_back(std::move(capture.clips[i]));
    if (!capture.held_out.empty()) held_out.push_back(capture.held_out[i]);
  }
  capture.clips = std::move(clips);
  capture.held_out = std::move(held_out);
}

void note_removed_lens(CaptureCamera& camera, const RemovedLens& removed) {
  const auto known = [&](const RemovedLens& other) {
    return other.model == removed.model && other.lens == removed.lens;
  };
  if (!removed.lens.is_pinhole() &&
      std::none_of(camera.removed_lenses.begin(), camera.removed_lenses.end(), known))
    camera.removed_lenses.push_back(removed);
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
