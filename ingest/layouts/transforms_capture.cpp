// Reads D-NeRF, NeRF-synthetic, Nerfstudio and prepared captures. Alpha is kept; the background is
// chosen when a scene is loaded.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "ingest/layouts/layout_readers.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

CaptureFrame frame_of(const TransformsFrame& listed) {
  CaptureFrame frame;
  frame.frame.name = listed.name;
  frame.frame.camera_name = listed.camera_name;
  frame.frame.frame_number = listed.frame_number;
  frame.frame.time = listed.time.value_or(0);
  frame.frame.split = listed.split;
  frame.frame.camera = listed.camera;
  frame.image = listed.image;
  frame.mask = listed.mask;
  frame.image_name = frame.source.name = listed.name + listed.image.extension().string();
  frame.file_path = listed.name + ".png";
  return frame;
}

}  // namespace

Capture read_transforms_layout(const std::filesystem::path& folder, const IngestOptions& options) {
  TransformsCapture listed = read_transforms_capture(folder);
  if (!listed.clips.empty())
    throw InputError(fmt::format(
        "{}: is a prepared scene whose frames are in {}; prepare that capture again instead",
        folder.string(), listed.clips.front().files.front().parent_path().string()));
  Capture capture;
  capture.folder = folder;
  capture.layout = "transforms";
  capture.warnings = std::move(listed.warnings);
  capture.notes = std::move(listed.notes);
  note_missing(folder, listed.missing, "the transforms file", options.strict, capture.warnings);
  std::map<std::string, size_t> cameras;  // name → index
  for (const TransformsFrame& frame : listed.frames) {
    capture.frames.push_back(frame_of(frame));
    capture.frames.back().view = int64_t(capture.views.size());
    capture.views.push_back({frame.intrinsics, frame.lens.lens, frame.lens.model, frame.where});
    const auto [camera, is_new] = cameras.emplace(frame.camera_name, capture.cameras.size());
    if (is_new) capture.cameras.push_back({.name = frame.camera_name});
    note_removed_lens(capture.cameras[camera->second], {frame.lens.model, frame.lens.lens});
  }
  capture.points_axis = times_of(listed, true).axis;
  capture.is_timed = listed.frames.front().time.has_value() && !listed.prepared_static;
  capture.times_from = listed.files.front();
  capture.stated_axis = listed.prepared_axis;
  capture.prepared_from_source = listed.prepared_from_source;
  if (!listed.prepared_axis) take_origin_out(capture);
  capture.points_file = listed.points_file;
  for (const std::filesystem::path& file : listed.files)
    capture.files.emplace_back(file.filename().string(), file);
  return capture;
}

}  // namespace tessera
