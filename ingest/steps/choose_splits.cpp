// Splits go by the whole list of a layout, before what is not there is left out of it.
#include <fmt/format.h>

#include <algorithm>

#include "ingest/steps/steps.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Errors: InputError: the capture states a split itself.
void require_unstated(const Capture& capture, const IngestOptions& options) {
  for (const CaptureFrame& frame : capture.frames)
    if (frame.frame.split != Split::kTrain)
      throw InputError(fmt::format(
          "{}: is stated as a test frame, but {} is given; leave the option out, or remove the "
          "stated split",
          frame.view < 0 ? frame.frame.name : capture.views[size_t(frame.view)].where,
          options.test_every ? "--test-every" : "--held-out"));
}

void hold_out_cameras(const std::vector<std::string>& held_out, Capture& capture) {
  std::vector<std::string> cameras;
  for (const CaptureCamera& camera : capture.cameras) cameras.push_back(camera.name);
  const std::vector<Split> splits = held_out_splits_of(cameras, held_out, capture.layout);
  for (CaptureFrame& frame : capture.frames) {
    const auto camera = std::find(cameras.begin(), cameras.end(), frame.frame.camera_name);
    if (camera != cameras.end()) frame.frame.split = splits[size_t(camera - cameras.begin())];
  }
}

void hold_out_images(int64_t every, Capture& capture) {
  std::vector<std::string> names;
  for (const CaptureFrame& frame : capture.frames)
    names.push_back(frame.image_name.empty() ? frame.frame.name : frame.image_name);
  const std::vector<Split> splits = every_nth_split(names, every);
  for (size_t i = 0; i < splits.size(); ++i) capture.frames[i].frame.split = splits[i];
}

void leave_out_missing(Capture& capture) {
  std::erase_if(capture.frames,
                [](const CaptureFrame& frame) { return frame.view >= 0 && frame.image.empty(); });
}

/// Where images were held out by their number, one is left to train on.
void keep_one_for_training(Capture& capture) {
  std::vector<CaptureFrame>& frames = capture.frames;
  if (std::any_of(frames.begin(), frames.end(),
                  [](const CaptureFrame& f) { return f.frame.split == Split::kTrain; }))
    return;
  if (frames.size() > 1)
    throw InputError(
        fmt::format("{}: all {} photos that are there are held out, none is left to train on; pass "
                    "--test-every 0",
                    capture.layout, frames.size()));
  frames.front().frame.split = Split::kTrain;
  capture.warnings.push_back(
      fmt::format("{}: there is one photo only, none is held out for testing", capture.layout));
}

}  // namespace

Capture choose_splits(Capture capture, const StepContext& context) {
  const IngestOptions& options = context.options;
  if (capture.clips.size() > 1) return capture;  // whole cameras, which choose_frames() took over
  const bool by_name = !options.held_out.empty();
  const int64_t every = by_name ? 0 : options.test_every.value_or(capture.test_every);
  if (by_name || options.test_every) require_unstated(capture, options);
  if (every != 0) hold_out_images(every, capture);
  leave_out_missing(capture);
  if (by_name) hold_out_cameras(options.held_out, capture);
  if (every != 0) keep_one_for_training(capture);
  return capture;
}

}  // namespace tessera
