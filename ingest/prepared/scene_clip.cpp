// The entries of transforms.json, and the reader of the program.
#include "ingest/prepared/scene_clip.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numeric>
#include <system_error>

#include "ingest/files/fnv1a.h"
#include "ingest/files/json_file.h"
#include "ingest/poses/pose_matrix.h"
#include "ingest/poses/transforms_values.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

const ClipReader* program_reader = nullptr;

struct LensField {
  const char* name;
  double Lens::*value;
};
constexpr LensField kLensFields[] = {{"k1", &Lens::k1}, {"k2", &Lens::k2}, {"k3", &Lens::k3},
                                     {"k4", &Lens::k4}, {"d1", &Lens::d1}, {"d2", &Lens::d2},
                                     {"d3", &Lens::d3}, {"p1", &Lens::p1}, {"p2", &Lens::p2},
                                     {"s1", &Lens::s1}, {"s2", &Lens::s2}, {"omega", &Lens::omega}};
constexpr const char* kProjections[] = {"pinhole", "fisheye", "field of view"};

ordered_json lens_json(const SceneClip& clip) {
  ordered_json lens{{"model", clip.lens_model},
                    {"projection", kProjections[size_t(clip.lens.projection)]}};
  for (const LensField& field : kLensFields)
    if (clip.lens.*field.value != 0) lens[field.name] = clip.lens.*field.value;
  return lens;
}

void read_lens(const json& entry, const std::string& where, SceneClip& clip) {
  const json lens = entry.value("lens", json::object());
  clip.lens_model = string_at(lens, "model", where);
  const std::string projection = string_at(lens, "projection", where);
  for (size_t i = 0; i < std::size(kProjections); ++i)
    if (projection == kProjections[i]) clip.lens.projection = Lens::Projection(i);
  for (const LensField& field : kLensFields)
    clip.lens.*field.value = finite_number(lens, field.name, where).value_or(0);
}

/// Runs of one distance: [first, distance, how many].
ordered_json runs_json(const std::vector<int64_t>& ticks) {
  ordered_json runs = ordered_json::array();
  for (size_t i = 0; i < ticks.size();) {
    const int64_t step = i + 1 < ticks.size() ? ticks[i + 1] - ticks[i] : 1;
    size_t end = i + 1;
    while (end < ticks.size() && ticks[end] - ticks[end - 1] == step) ++end;
    runs.push_back({ticks[i], step, end - i});
    i = end;
  }
  return runs;
}

[[noreturn]] void refuse(const std::string& where, const char* what) {
  throw InputError(
      fmt::format("{}: {} is missing or damaged; prepare the capture again", where, what));
}

/// `most`: bytes of the files, of which a frame has one or more.
std::vector<int64_t> ticks_of(const json& runs, int64_t most, const std::string& where) {
  if (!runs.is_array()) refuse(where, "ticks");
  std::vector<int64_t> ticks;
  for (const json& run : runs) {
    if (!run.is_array() || run.size() != 3 || !run[0].is_number_integer() ||
        !run[1].is_number_integer() || !run[2].is_number_integer())
      refuse(where, "ticks");
    const int64_t first = run[0], step = run[1], count = run[2];
    if (step < 1 || count < 1 || count > most - int64_t(ticks.size()) ||
        (!ticks.empty() && first <= ticks.back()))
      refuse(where, "ticks");
    for (int64_t k = 0; k < count; ++k) ticks.push_back(first + k * step);
  }
  if (ticks.empty()) refuse(where, "ticks");
  return ticks;
}

ordered_json intrinsics_json(const Camera& camera) {
  ordered_json object{{"w", camera.width},   {"h", camera.height}, {"fl_x", camera.fl_x},
                      {"fl_y", camera.fl_y}, {"cx", camera.cx},    {"cy", camera.cy}};
  if (camera.readout != 0) object["readout"] = camera.readout;
  return object;
}

void read_intrinsics(const json& entry, const std::string& where, Camera& camera) {
  if (!entry.is_object()) refuse(where, "stored");
  const auto number = [&](const char* key) {
    const auto value = finite_number(entry, key, where);
    if (!value || !(*value > 0)) refuse(where, key);
    return *value;
  };
  camera.width = int(number("w"));
  camera.height = int(number("h"));
  camera.fl_x = number("fl_x");
  camera.fl_y = number("fl_y");
  camera.cx = finite_number(entry, "cx", where).value_or(camera.width / 2.0);
  camera.cy = finite_number(entry, "cy", where).value_or(camera.height / 2.0);
  camera.readout = finite_number(entry, "readout", where).value_or(0);
}

void read_files(const json& entry, const std::string& where, SceneClip& clip) {
  const auto files = entry.find("files");
  if (files == entry.end() || !files->is_array() || files->empty()) refuse(where, "files");
  for (const json& file : *files) {
    if (!file.is_object()) refuse(where, "files");
    clip.files.emplace_back(string_at(file, "path", where));
    clip.bytes.push_back(int64_t(finite_number(file, "bytes", where).value_or(-1)));
    clip.samples.push_back(string_at(file, "sample", where));
    if (clip.files.size() == 1) continue;
    const auto first = finite_number(file, "first", where);
    const auto shift = finite_number(file, "shift", where);
    if (!first || !shift) refuse(where, "files");
    clip.chapters.push_back({int64_t(*first), int64_t(*shift)});
  }
}

}  // namespace

void check_source(const SceneClip& clip) {
  for (size_t i = 0; i < clip.files.size(); ++i) {
    const std::string file = clip.files[i].string();
    std::error_code absent;
    const auto bytes = std::filesystem::file_size(clip.files[i], absent);
    if (absent)
      throw InputError(fmt::format(
          "{}: cannot be read ({}); the frames of camera {} are in it: restore it, or prepare the "
          "capture again",
          file, absent.message(), clip.camera));
    if (int64_t(bytes) != clip.bytes[i])
      throw InputError(fmt::format(
          "{}: has {} bytes, and the scene was made when it had {}; restore it, or prepare the "
          "capture again",
          file, bytes, clip.bytes[i]));
    if (!clip.samples[i].empty() && sampled_hash(clip.files[i]) != clip.samples[i])
      throw InputError(fmt::format(
          "{}: is another video than the one that the scene was made of; restore it, or prepare "
          "the capture again",
          file));
  }
}

std::string SceneClip::frame_name(int64_t number) const {
  return fmt::format("{}/{:05}", camera, number);
}

ordered_json to_json(const SceneClip& clip) {
  ordered_json files = ordered_json::array();
  for (size_t i = 0; i < clip.files.size(); ++i) {
    files.push_back(
        {{"path", clip.files[i].string()}, {"bytes", clip.bytes[i]}, {"sample", clip.samples[i]}});
    if (i == 0) continue;
    files.back()["first"] = clip.chapters[i - 1].first;
    files.back()["shift"] = clip.chapters[i - 1].shift;
  }
  ordered_json matrix = ordered_json::array();
  for (const auto& row : gl_pose_of(clip.prepared)) matrix.push_back(row);
  matrix.push_back({0.0, 0.0, 0.0, 1.0});
  ordered_json entry{{"camera", clip.camera}, {"split", name_of(clip.split)}};
  entry.update(intrinsics_json(clip.prepared));
  entry["transform_matrix"] = std::move(matrix);
  if (!clip.mask_path.empty()) entry["mask_path"] = clip.mask_path;
  entry["files"] = std::move(files);
  entry["hash"] = clip.hash;
  entry["time_base"] = {clip.time_base.numerator, clip.time_base.denominator};
  entry["time_offset"] = clip.time_offset;
  entry["ticks"] = runs_json(clip.ticks);
  entry["stored"] = intrinsics_json(clip.stored);
  entry["lens"] = lens_json(clip);
  entry["field_of_view"] = name_of(clip.field_of_view);
  entry["scale"] = clip.scale;
  return entry;
}

SceneClip scene_clip_of(const json& entry, const std::string& where) {
  if (!entry.is_object()) refuse(where, "the entry");
  SceneClip clip;
  clip.camera = string_at(entry, "camera", where);
  if (clip.camera.empty()) refuse(where, "camera");
  const std::string split = string_at(entry, "split", where);
  if (split != name_of(Split::kTrain) && split != name_of(Split::kTest)) refuse(where, "split");
  clip.split = split == name_of(Split::kTest) ? Split::kTest : Split::kTrain;
  read_files(entry, where, clip);
  clip.hash = string_at(entry, "hash", where);
  const json base = entry.value("time_base", json());
  if (!base.is_array() || base.size() != 2 || !base[0].is_number_integer() ||
      !base[1].is_number_integer() || base[0] < 1 || base[1] < 1)
    refuse(where, "time_base");
  clip.time_base = {base[0], base[1]};
  clip.time_offset = finite_number(entry, "time_offset", where).value_or(0);
  check_source(clip);
  clip.ticks = ticks_of(entry.value("ticks", json()),
                        std::accumulate(clip.bytes.begin(), clip.bytes.end(), int64_t{0}), where);
  read_intrinsics(entry.value("stored", json()), where, clip.stored);
  read_lens(entry, where, clip);
  const std::string view = string_at(entry, "field_of_view", where);  // "": of an earlier version
  if (view == name_of(FieldOfView::kFull))
    clip.field_of_view = FieldOfView::kFull;
  else if (!view.empty() && view != name_of(FieldOfView::kValid))
    refuse(where, "field_of_view");
  clip.scale = finite_number(entry, "scale", where).value_or(1);
  if (!(clip.scale > 0 && clip.scale <= 1)) refuse(where, "scale");
  read_intrinsics(entry, where, clip.prepared);
  set_pose(clip.prepared, pose_rows({entry, where}), where);
  clip.mask_path = string_at(entry, "mask_path", where);
  return clip;
}

const ClipReader* clip_reader() {
  return program_reader;
}

void set_clip_reader(const ClipReader* reader) {
  program_reader = reader;
}

}  // namespace tessera
