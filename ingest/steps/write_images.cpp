// Image files are read and written on all threads; clips are decoded one after another, or not at
// all where their frames stay in them.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <optional>

#include "ingest/files/fnv1a.h"
#include "ingest/files/png.h"
#include "ingest/steps/clip_images.h"
#include "ingest/steps/image_intake.h"
#include "ingest/steps/mask_source.h"
#include "ingest/steps/prepared_image.h"
#include "ingest/steps/sample.h"
#include "ingest/steps/steps.h"
#include "ingest/video/clip_frames.h"
#include "ingest/video/clip_mistakes.h"
#include "ingest/video/frame_colour.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

/// The camera of an image of this size. Errors: InputError: the view is of another shape.
Camera camera_of_view(const CaptureFrame& frame, const StatedView& view, const Image8& image) {
  Camera camera = frame.frame.camera;
  if (view.intrinsics) {
    set_intrinsics(camera, *view.intrinsics, image.width, image.height, view.where);
    return camera;
  }
  if (!same_shape(camera.width, camera.height, image.width, image.height))
    throw InputError(fmt::format(
        "{}: is {}x{}, its pose was made for {}x{}; use the photos that the poses were made of "
        "(not turned), or reduced copies of the same shape",
        frame.image.string(), image.width, image.height, camera.width, camera.height));
  return camera.resized(image.width, image.height);
}

void write_image_file(const StatedView& view, Image8 image, const StepContext& context,
                      double scale, std::atomic<int64_t>& object_masks, CaptureFrame& frame) {
  const Camera camera = camera_of_view(frame, view, image);
  const ImagePreparation preparation(camera, view.lens, context.options.field_of_view,
                                     fmt::format("{} ({})", view.where, view.lens_model), scale);
  std::optional<Image8> mask;
  if (!frame.mask.empty())
    mask = read_mask(frame.mask, camera.width, camera.height, context.options, object_masks);
  if (mask || preparation.has_blanks()) {
    frame.mask_path = "masks/" + frame.frame.name + ".png";
    preparation.write_mask(context.folder / frame.mask_path, std::move(mask));
  }
  frame.field_of_view = preparation.kept();
  write_png(context.folder / frame.file_path, preparation.prepared(std::move(image)));
  frame.frame.camera = preparation.camera();
}

/// Files that cannot be read are left out, with their cameras.
void write_image_files(const StepContext& context, Capture& capture) {
  ImageIntake intake(capture.frames.size());
  std::atomic<int64_t> object_masks{0};
  convert_images(capture.frames.size(), context.progress, [&](size_t i) {
    CaptureFrame& frame = capture.frames[i];
    const StatedView& view = capture.views[size_t(frame.view)];
    const int width = view.intrinsics ? view.intrinsics->w.value_or(0) : frame.frame.camera.width;
    const int height = view.intrinsics ? view.intrinsics->h.value_or(0) : frame.frame.camera.height;
    std::optional<Image8> image = intake.read(i, frame.image, width, height);
    if (!image) return;
    write_image_file(view, std::move(*image), context, capture.scale, object_masks, frame);
    if (!frame.source.name.empty()) frame.source.hash = source_hash(frame.image);
  });
  intake.finish(context.options.strict, capture);
  note_object_masks(object_masks, capture);
  for (const CaptureFrame& frame : capture.frames)
    if (!frame.source.name.empty()) capture.sources.push_back(frame.source);
}

/// Each mask file once; one of all frames is called as the camera.
void write_clip_masks(const RigClip& clip, const std::vector<CaptureFrame*>& frames,
                      const ImagePreparation& preparation, const StepContext& context,
                      std::atomic<int64_t>& object_masks) {
  const bool is_shared = std::all_of(frames.begin(), frames.end(), [&](const CaptureFrame* frame) {
    return frame->mask == frames.front()->mask;
  });
  std::map<std::filesystem::path, std::string> written;
  for (CaptureFrame* frame : frames) {
    if (frame->mask.empty() && !preparation.has_blanks()) continue;
    const auto [file, is_new] = written.try_emplace(
        frame->mask, fmt::format("masks/{}.png", is_shared ? clip.name : frame->frame.name));
    frame->mask_path = file->second;
    if (!is_new) continue;
    std::optional<Image8> mask;
    if (!frame->mask.empty())
      mask = read_mask(frame->mask, clip.timeline.width, clip.timeline.height, context.options,
                       object_masks);
    preparation.write_mask(context.folder / file->second, std::move(mask));
  }
}

/// Adds the conversion of a clip to those of others, each once.
void record_tone_map(const std::string& of_clip, Capture& capture) {
  if (of_clip == "none" || capture.tone_map.find(of_clip) != std::string::npos) return;
  capture.tone_map = capture.tone_map == "none" ? of_clip : capture.tone_map + "; " + of_clip;
}

void write_clip(const RigClip& clip, const std::vector<CaptureFrame*>& frames,
                const StepContext& context, std::atomic<int64_t>& object_masks, Capture& capture,
                int64_t& done, FrozenFrames& frozen) {
  const RigCamera& stored = *clip.camera;
  const ImagePreparation preparation(stored.camera, stored.lens, context.options.field_of_view,
                                     clip.video.string() + " (" + stored.lens_model + ")",
                                     capture.scale);
  std::string tone_map = tone_map_of(clip.timeline.colour);
  if (!capture.by_reference) {
    const std::string doing = "decoding " + clip.video.filename().string();
    std::vector<int64_t> ticks;
    for (const CaptureFrame* frame : frames) ticks.push_back(*frame->ticks);
    const auto note = [&](const VideoFrame& decoded) {
      tone_map = tone_map_of(decoded.colour);
      frozen.see(decoded.image, clip.timeline.time_base.at(decoded.ticks));
      if (decoded.image.channels == 4) capture.background = "alpha kept";
      context.progress(doing, ++done, int64_t(capture.frames.size()));
    };
    prepare_clip_images(clip, ticks, preparation, note, [&](size_t i, const Image8& image) {
      write_png(context.folder / frames[i]->file_path, image);
    });
  }
  write_clip_masks(clip, frames, preparation, context, object_masks);
  for (CaptureFrame* frame : frames) {
    frame->frame.camera = preparation.camera();
    frame->field_of_view = preparation.kept();
  }
  record_tone_map(tone_map, capture);
}

void write_clips(const StepContext& context, Capture& capture) {
  int64_t done = 0;
  std::atomic<int64_t> object_masks{0};
  std::vector<FrozenStretch> frozen;
  for (const RigClip& clip : capture.clips) {
    std::vector<CaptureFrame*> frames;
    for (CaptureFrame& frame : capture.frames)
      if (frame.frame.camera_name == clip.name) frames.push_back(&frame);
    FrozenFrames stretch(clip.name);
    write_clip(clip, frames, context, object_masks, capture, done, stretch);
    frozen.push_back(stretch.longest());
  }
  for (std::string& line : frozen_warnings(frozen)) capture.warnings.push_back(std::move(line));
  note_object_masks(object_masks, capture);
}

/// Why frames cannot stay in their videos; "" where they can.
std::string reason_against_clips(const IngestOptions& options, const Capture& capture) {
  if (capture.clips.empty() || capture.frames.front().view >= 0)
    return "these frames are images, or of a camera that moves";
  for (const RigClip& clip : capture.clips)
    if (!clip.images.empty()) return "camera " + clip.name + " is a sequence of images";
  if (options.fit_exposure) return "--fit-exposure changes the pixels of frames";
  std::map<std::string, const CaptureFrame*> first;  // by camera
  for (const CaptureFrame& frame : capture.frames) {
    const CaptureFrame& like = *first.try_emplace(frame.frame.camera_name, &frame).first->second;
    if (frame.mask != like.mask)
      return "camera " + frame.frame.camera_name + " has a mask for each frame";
    if (frame.frame.split != like.frame.split)
      return "some frames of camera " + frame.frame.camera_name + " are held out (--test-every)";
  }
  return "";
}

/// Seconds from the first to the last frame of the clip that is longest.
double longest_clip(const Capture& capture) {
  double longest = 0;
  for (const RigClip& clip : capture.clips) {
    std::optional<int64_t> first;
    for (const CaptureFrame& frame : capture.frames) {
      if (frame.frame.camera_name != clip.name || !frame.ticks) continue;
      if (!first) first = *frame.ticks;
      longest = std::max(longest, clip.timeline.time_base.at(*frame.ticks - *first));
    }
  }
  return longest;
}

/// Whether frames stay in their videos. Errors: InputError: they are to, and cannot.
bool stays_in_clips(const IngestOptions& options, const Capture& capture) {
  if (options.frames_as == FramesAs::kPng) return false;
  const std::string reason = reason_against_clips(options, capture);
  if (options.frames_as == FramesAs::kAuto)
    return reason.empty() && longest_clip(capture) > kLongClip;
  if (!reason.empty()) throw InputError("--frames-as video: " + reason + "; leave the option out");
  return true;
}

}  // namespace

Capture write_images(Capture capture, const StepContext& context) {
  capture.scale = scale_of(capture, context.options);
  capture.by_reference = stays_in_clips(context.options, capture);
  if (capture.frames.front().view < 0)
    write_clips(context, capture);
  else
    write_image_files(context, capture);
  for (const RigClip& clip : capture.clips)
    capture.sources.push_back({(clip.images.empty() ? clip.video.lexically_relative(capture.folder)
                                                    : clip.video.filename())
                                   .string(),
                               clip_hash(clip)});
  for (const auto& [name, file] : capture.files)
    capture.sources.push_back({name, source_hash(file)});
  if (!capture.clips.empty() && capture.frames.front().view >= 0)
    std::filesystem::remove_all(capture.photos);  // frames of a moving camera
  return capture;
}

}  // namespace tessera
