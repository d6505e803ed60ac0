// Chooses the files of a folder, parses the entries of frames, and checks the conditions on all
// frames.
#include "ingest/prepared/transforms_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/colmap/colmap_model.h"
#include "ingest/files/folders.h"
#include "ingest/images/image_index.h"
#include "ingest/images/image_paths.h"
#include "ingest/poses/transforms_values.h"
#include "ingest/prepared/camera_labels.h"
#include "ingest/prepared/clip_frame_list.h"
#include "ingest/prepared/frame_times.h"
#include "ingest/prepared/times_and_cameras.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;

struct SplitFile {
  const char* name;
  Split split;
};

/// Whether the images that frames name must be there.
enum class Images { kRequired, kListed, kUnused };

constexpr std::array<SplitFile, 3> kSplitFiles{{{"transforms_train.json", Split::kTrain},
                                                {"transforms_val.json", Split::kVal},
                                                {"transforms_test.json", Split::kTest}}};

/// `split` of the frame, else Nerfstudio's lists of file names, else what the file stands for.
Split split_of(const StatedObject& frame, const StatedObject& file, Split split_of_file) {
  const std::string& where = frame.where();
  const std::string stated = frame.text("split");
  std::optional<Split> of_list;
  for (const SplitFile& candidate : kSplitFiles) {
    if (stated == name_of(candidate.split)) return candidate.split;
    const json* const list = file.at(fmt::format("{}_filenames", name_of(candidate.split)));
    if (stated.empty() && !of_list && list != nullptr && list->is_array() &&
        std::find(list->begin(), list->end(), *frame.at("file_path")) != list->end())
      of_list = candidate.split;
  }
  if (of_list) return *of_list;
  if (!stated.empty())
    throw InputError(
        fmt::format("{}: split is '{}', expected train, val or test; correct it", where, stated));
  return split_of_file;
}

/// The file of `mask_path`, which is relative to `folder`; empty when none is stated.
std::filesystem::path mask_of(const StatedObject& entry, const std::filesystem::path& image,
                              const std::filesystem::path& folder, ImageIndex& files) {
  const std::string& where = entry.where();
  const std::string stated = entry.text("mask_path");
  if (stated.empty()) return {};
  std::filesystem::path path = files.find(stated);
  if (path.empty() || path == image)
    throw InputError(fmt::format("{}: no such mask as {}; restore it or take mask_path out", where,
                                 (folder / stated).string()));
  return path;
}

/// Of an image below the folder of the json by its place there, whatever the json states; of any
/// other by what is stated.
std::string name_of_frame(const std::string& file_path, const std::filesystem::path& image,
                          const std::filesystem::path& folder) {
  const std::filesystem::path below = image.lexically_relative(folder);
  const bool elsewhere = image.empty() || below.empty() || *below.begin() == "..";
  return name_of_image(elsewhere ? file_path : below.generic_string());
}

/// A transforms file that is being read.
struct FileOfFrames {
  const StatedObject& values;
  const StatedIntrinsics globals;
  const std::filesystem::path& path;
  const Split split;
  const Images images;
  ImageIndex& found;
  std::set<std::string>& unread;
};

TransformsFrame parse_frame(const json& values, size_t index, const FileOfFrames& file) {
  TransformsFrame frame;
  frame.where = fmt::format("{}, frame {}", file.path.string(), index);
  std::string file_path =
      values.is_object() ? string_at(values, "file_path", frame.where) : std::string();
  if (file_path.empty() && file.images == Images::kUnused) file_path = fmt::format("{:04}", index);
  if (file_path.empty())
    throw InputError(fmt::format("{}: has no file_path; name its image", frame.where));
  frame.where += fmt::format(" ({})", file_path);
  const StatedObject entry(values, frame.where);
  entry.take("file_path");
  frame.split = split_of(entry, file.values, file.split);
  const std::filesystem::path folder = file.path.parent_path();
  if (file.images != Images::kUnused) {
    frame.image = file.found.find(file_path);
    if (frame.image.empty() && file.images == Images::kRequired)
      frame.image = require_image(folder, file_path, frame.where);
    frame.mask = mask_of(entry, frame.image, folder, file.found);
  }
  frame.name = name_of_frame(file_path, frame.image, folder);
  frame.time = stated_time(entry);
  frame.other_times = other_times_of(entry);
  frame.camera_key = camera_key_of(entry);
  if (file.images == Images::kListed)
    frame.lens = stated_lens(entry, file.values);
  else
    refuse_distortion(entry);
  frame.intrinsics = intrinsics_of(entry).or_else(file.globals);
  set_pose(frame.camera, pose_rows(entry), frame.where);
  const size_t slash = frame.name.rfind('/');
  frame.camera_name = slash == std::string::npos
                          ? name_of(frame.split)
                          : std::filesystem::path(frame.name.substr(0, slash)).filename().string();
  frame.frame_number = -1;  // counted once all frames are known
  if (const json* const made_by_us = entry.at("tessera")) {
    frame.camera_name = string_at(*made_by_us, "camera", frame.where);
    frame.camera_is_stated = true;
    frame.frame_number = int64_t(finite_number(*made_by_us, "frame", frame.where).value_or(-1));
  }
  if (file.images == Images::kListed) account_for(entry, file.unread);
  return frame;
}

void read_prepared_object(const json& object, const std::string& where,
                          TransformsCapture& capture) {
  constexpr double kVersion = 2;  // 1: every frame is an image
  const double version = finite_number(object, "format_version", where).value_or(kVersion);
  if (version > kVersion)
    throw InputError(fmt::format(
        "{}: prepared scene of format version {}, this program knows {}; prepare the capture "
        "again or use the newer program",
        where, version, kVersion));
  const json time = object.contains("time") ? object["time"] : json::object();
  TimeAxis axis;
  axis.origin = finite_number(time, "origin", where).value_or(axis.origin);
  axis.duration = finite_number(time, "duration", where).value_or(axis.duration);
  capture.prepared_axis = axis;
  capture.prepared_static = StatedObject(time, where).is_true("static");
  const double clip = finite_number(time, "static_of", where).value_or(0);
  capture.prepared_static_of =
      capture.prepared_static && clip >= 1 && clip < 1e9 ? int64_t(clip) : 0;
  capture.prepared_from_source = world_transform_of(object, where);
  if (const auto cameras = object.find("cameras"); cameras != object.end() && cameras->is_array())
    for (const json& camera : *cameras) {
      const StatedObject row(camera, where);
      const std::string source = row.text("time_offset_source");
      const bool is_moved = row.number("time_offset").value_or(0) != 0;
      if (is_moved && (source == "motion" || source == "audio"))
        capture.measured_clocks.insert(row.text("name"));
    }
}

void read_file(const std::filesystem::path& path, Split split_of_file, Images images,
               TransformsCapture& capture) {
  const json file = read_json(path);
  const std::string where = path.string();
  const auto frames = file.find("frames");
  if (!file.is_object() || frames == file.end() || !frames->is_array())
    throw InputError(
        fmt::format("{}: has no list 'frames'; expected a NeRF transforms file", where));
  capture.files.push_back(path);
  const StatedObject stated(file, where);
  if (images != Images::kListed) refuse_distortion(stated);
  if (capture.points_file.empty()) capture.points_file = stated.text("ply_file_path");
  const json* const ours = stated.at("tessera");
  if (ours != nullptr) read_prepared_object(*ours, where, capture);
  ImageIndex found(path.parent_path());
  std::set<std::string> unread;
  const FileOfFrames of_frames{stated, intrinsics_of(stated), path, split_of_file, images, found,
                               unread};
  for (size_t i = 0; i < frames->size(); ++i)
    capture.frames.push_back(parse_frame((*frames)[i], i, of_frames));
  for (std::string& line : found.lines()) capture.warnings.push_back(std::move(line));
  if (ours != nullptr) add_clip_frames(*ours, path, capture);
  if (images != Images::kListed || ours != nullptr) return;
  stated.take("frames");
  account_for(stated, unread);
  note_unread_keys(where, unread, capture.notes);
}

/// The same image may be in two splits (val copied from test); its second name has the split.
void make_names_unique(TransformsCapture& capture) {
  std::set<std::string> taken;
  for (TransformsFrame& frame : capture.frames) {
    if (taken.insert(frame.name).second) continue;
    frame.name += fmt::format("@{}", name_of(frame.split));
    if (!taken.insert(frame.name).second)
      throw InputError(fmt::format("{}: the image is listed twice; remove one entry", frame.where));
  }
}

/// What needs all frames.
void complete(TransformsCapture& capture, Images images) {
  if (capture.frames.empty())
    throw InputError(fmt::format("{}: lists no frames; export the cameras again",
                                 capture.files.front().string()));
  make_names_unique(capture);
  if (images == Images::kUnused)
    set_path_times(capture);
  else
    set_times_and_cameras(capture);
}

TransformsCapture read_files(const std::filesystem::path& folder, Images images) {
  require_folder(folder);
  TransformsCapture capture;
  if (std::filesystem::exists(folder / kSplitFiles[0].name)) {
    for (const SplitFile& file : kSplitFiles)
      if (std::filesystem::exists(folder / file.name))
        read_file(folder / file.name, file.split, images, capture);
  } else if (std::filesystem::exists(folder / "transforms.json")) {
    read_file(folder / "transforms.json", Split::kTrain, images, capture);
  } else {
    throw InputError(fmt::format(
        "{}: has neither transforms.json nor transforms_train.json; prepare the capture with "
        "`tessera ingest`",
        folder.string()));
  }
  complete(capture, images);
  return capture;
}

/// After frames were numbered and named, so that those of others do not change.
void leave_out_missing(TransformsCapture& capture) {
  const std::string first = capture.frames.front().where;
  std::erase_if(capture.frames, [&](const TransformsFrame& frame) {
    const bool missing = frame.image.empty() && frame.clip < 0;
    if (missing) capture.missing.push_back(frame.name);
    return missing;
  });
  if (capture.frames.empty())
    throw InputError(fmt::format("{}: no such image, nor any of the {} others; restore them", first,
                                 capture.missing.size() - 1));
}

void check_prepared(const TransformsCapture& capture) {
  if (!(capture.prepared_axis->duration > 0))
    throw InputError(fmt::format(
        "{}: tessera.time.duration is {}, expected more than 0; prepare the capture again",
        capture.files.front().string(), capture.prepared_axis->duration));
  for (const TransformsFrame& frame : capture.frames)
    if (frame.time.value_or(0) < 0 || frame.time.value_or(0) > 1)
      throw InputError(fmt::format(
          "{}: time is {}, a prepared scene has times from 0 to 1; prepare the capture again",
          frame.where, *frame.time));
}

/// COLMAP's poses beside a transforms file are not read, nor is their protocol of test views.
void warn_of_unread_model(const std::filesystem::path& folder, TransformsCapture& capture) {
  if (is_prepared_scene(folder)) return;
  const std::filesystem::path model = find_colmap_model(folder);
  if (model.empty()) return;
  capture.warnings.push_back(fmt::format(
      "{}: read as {}; {} is there, too, and is not read: move the transforms file away to have "
      "the COLMAP model in its place",
      folder.string(), capture.files.front().filename().string(),
      model.lexically_relative(folder).string()));
}

}  // namespace

TransformsCapture read_transforms(const std::filesystem::path& folder) {
  TransformsCapture capture = read_files(folder, Images::kRequired);
  warn_of_unread_model(folder, capture);
  return capture;
}

TransformsCapture read_transforms_capture(const std::filesystem::path& folder) {
  TransformsCapture capture = read_files(folder, Images::kListed);
  leave_out_missing(capture);
  warn_of_unread_model(folder, capture);
  return capture;
}

TransformsCapture read_camera_path(const std::filesystem::path& file) {
  TransformsCapture capture;
  read_file(file, Split::kTest, Images::kUnused, capture);
  complete(capture, Images::kUnused);
  return capture;
}

bool has_transforms(const std::filesystem::path& folder) {
  return std::filesystem::exists(folder / "transforms.json") ||
         std::filesystem::exists(folder / kSplitFiles[0].name);
}

bool is_prepared_scene(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "transforms.json";
  if (!std::filesystem::is_regular_file(path)) return false;
  try {
    const json file = read_json(path);
    return file.is_object() && file.contains("tessera");
  } catch (const InputError&) {
    return false;
  }
}

std::set<std::string> files_of_scene(const std::filesystem::path& folder) {
  if (!is_prepared_scene(folder)) return {};
  std::set<std::string> names{"transforms.json"};
  const auto add = [&](const auto& self, const json& value) -> void {
    if (value.is_string()) names.insert(value.get<std::string>());
    if (value.is_structured())
      for (const json& inner : value) self(self, inner);
  };
  add(add, read_json(folder / "transforms.json"));
  return names;
}

NormalisedTimes times_of(const TransformsCapture& capture, bool allow_static) {
  if (capture.prepared_axis) check_prepared(capture);
  const bool has_times = capture.frames.front().time.has_value();
  if (!has_times || capture.prepared_static)
    return {std::vector<double>(capture.frames.size(), 0.0),
            capture.prepared_axis.value_or(TimeAxis{}), true};
  std::vector<double> times;
  for (const TransformsFrame& frame : capture.frames) times.push_back(*frame.time);
  NormalisedTimes normalised = normalise_times(times, allow_static, capture.files.front().string());
  if (capture.prepared_axis && !normalised.is_static)
    return {std::move(times), *capture.prepared_axis, false};
  return normalised;
}

}  // namespace tessera
