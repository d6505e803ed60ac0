// Writes transforms.json in the convention of Nerfstudio with an additional object `tessera`.
#include "ingest/prepared/prepared_scene.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/colmap/colmap_records.h"
#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "ingest/files/json_file.h"
#include "ingest/poses/pose_matrix.h"
#include "ingest/prepared/scene_clip.h"

namespace tessera {
namespace {

using nlohmann::ordered_json;

ordered_json rational_json(const Rational& value) {
  return ordered_json::array({value.numerator, value.denominator});
}

ordered_json frame_json(const CaptureFrame& prepared) {
  const Frame& frame = prepared.frame;
  const Camera& camera = frame.camera;
  ordered_json matrix = ordered_json::array();
  for (const auto& row : gl_pose_of(camera)) matrix.push_back(row);
  matrix.push_back({0.0, 0.0, 0.0, 1.0});
  ordered_json tessera{{"camera", frame.camera_name}, {"frame", frame.frame_number}};
  if (prepared.ticks) tessera["ticks"] = *prepared.ticks;
  ordered_json file{{"file_path", prepared.file_path},
                    {"split", name_of(frame.split)},
                    {"time", frame.time},
                    {"w", camera.width},
                    {"h", camera.height},
                    {"fl_x", camera.fl_x},
                    {"fl_y", camera.fl_y},
                    {"cx", camera.cx},
                    {"cy", camera.cy},
                    {"transform_matrix", std::move(matrix)},
                    {"tessera", std::move(tessera)}};
  if (camera.readout != 0) file["readout"] = camera.readout;
  if (!prepared.mask_path.empty()) file["mask_path"] = prepared.mask_path;
  return file;
}

/// 4×4, prepared world from source's world: scale · rotation | translation.
ordered_json world_transform_json(const Similarity& transform) {
  const glm::dmat3 m = transform.scale * transform.rotation;
  ordered_json matrix = ordered_json::array();
  for (int r = 0; r < 3; ++r)
    matrix.push_back({m[0][r], m[1][r], m[2][r], transform.translation[r]});
  matrix.push_back({0.0, 0.0, 0.0, 1.0});
  return matrix;
}

/// Of each camera whose images were resampled: what was removed. {} where nothing was.
ordered_json removed_lenses_json(const CaptureCamera& camera) {
  ordered_json list = ordered_json::array();
  for (const RemovedLens& removed : camera.removed_lenses) {
    ordered_json row{{"model", removed.model}};
    for (const auto& [name, value] : lens_parameters(removed.lens)) row[name] = value;
    list.push_back(std::move(row));
  }
  return list;
}

/// "OPENCV, RADIAL"; "none" where no lens was removed.
std::string removed_models(const Capture& scene) {
  std::set<std::string> models;
  for (const CaptureCamera& camera : scene.cameras)
    for (const RemovedLens& removed : camera.removed_lenses) models.insert(removed.model);
  std::string joined;
  for (const std::string& model : models) joined += (joined.empty() ? "" : ", ") + model;
  return joined.empty() ? "none" : joined;
}

/// Which pixels the source's masks ignored.
const char* applied_masks(const Capture& scene) {
  if (std::all_of(scene.frames.begin(), scene.frames.end(),
                  [](const CaptureFrame& frame) { return frame.mask.empty(); }))
    return "none";
  return scene.inverted_masks ? "white ignored (inverted)" : "black ignored";
}

/// What became of the pixels beside those of the undistorted images.
const char* applied_crop(const Capture& scene, const std::string& removed) {
  if (removed == "none") return "none";
  const auto full = std::count_if(
      scene.frames.begin(), scene.frames.end(),
      [](const CaptureFrame& frame) { return frame.field_of_view == FieldOfView::kFull; });
  if (full == 0) return "zoomed to valid pixels";
  return size_t(full) == scene.frames.size() ? "blank pixels masked"
                                             : "zoomed to valid pixels, or blank pixels masked";
}

std::string hash_of(const Capture& scene, const std::filesystem::path& video) {
  const std::string name = video.lexically_relative(scene.folder).string();
  const auto found = std::find_if(scene.sources.begin(), scene.sources.end(),
                                  [&](const SourceFile& file) { return file.name == name; });
  return found == scene.sources.end() ? "" : found->hash;
}

/// A clip whose frames stay in it.
SceneClip scene_clip(const Capture& scene, const RigClip& clip, const CaptureCamera& camera) {
  SceneClip kept;
  kept.camera = clip.name;
  kept.files = {std::filesystem::absolute(clip.video)};
  for (const std::filesystem::path& chapter : clip.chapters)
    kept.files.push_back(std::filesystem::absolute(chapter));
  for (std::filesystem::path& file : kept.files) {
    file = file.lexically_normal();
    kept.bytes.push_back(int64_t(std::filesystem::file_size(file)));
    kept.samples.push_back(sampled_hash(file));
  }
  kept.hash = hash_of(scene, clip.video);
  kept.chapters = clip.timeline.chapters;
  kept.time_base = clip.timeline.time_base;
  kept.time_offset = camera.time_offset;
  kept.stored = clip.camera->camera;
  kept.lens = clip.camera->lens;
  kept.lens_model = clip.camera->lens_model;
  kept.scale = scene.scale;
  for (const CaptureFrame& frame : scene.frames) {
    if (frame.frame.camera_name != clip.name) continue;
    kept.split = frame.frame.split;
    kept.prepared = frame.frame.camera;
    kept.mask_path = frame.mask_path;
    kept.field_of_view = frame.field_of_view;
    kept.ticks.push_back(*frame.ticks);
  }
  return kept;
}

ordered_json clips_json(const Capture& scene) {
  ordered_json clips = ordered_json::array();
  for (size_t i = 0; i < scene.clips.size(); ++i)
    clips.push_back(to_json(scene_clip(scene, scene.clips[i], scene.cameras[i])));
  return clips;
}

ordered_json tessera_json(const Capture& scene) {
  ordered_json cameras = ordered_json::array(), sources = ordered_json::object();
  for (const CaptureCamera& camera : scene.cameras) {
    cameras.push_back({{"name", camera.name},
                       {"time_base", rational_json(camera.time_base)},
                       {"time_offset", camera.time_offset}});
    if (!camera.time_source.empty()) {
      cameras.back()["time_offset_source"] = camera.time_source;
      cameras.back()["time_offset_uncertainty"] = camera.time_uncertainty;
      cameras.back()["time_offset_measured"] = camera.time_measured;
    }
    if (!camera.removed_lenses.empty())
      cameras.back()["removed_lenses"] = removed_lenses_json(camera);
    if (camera.exposure_gain) cameras.back()["exposure_gain"] = *camera.exposure_gain;
  }
  const std::string removed = removed_models(scene);
  for (const SourceFile& source : scene.sources) sources[source.name] = source.hash;
  return {{"format_version", scene.by_reference ? 2 : 1},
          {"layout", scene.layout},
          {"applied",
           {{"scale", scene.scale},
            {"undistortion", removed},
            {"crop", applied_crop(scene, removed)},
            {"tone_map", scene.tone_map},
            {"world_transform", world_transform_json(scene.prepared_from_source)},
            {"background", scene.background},
            {"masks", applied_masks(scene)}}},
          {"time",
           {{"base", rational_json(scene.time_base)},
            {"origin", scene.time_axis.origin},
            {"duration", scene.time_axis.duration},
            {"static", scene.is_static}}},
          {"cameras", std::move(cameras)},
          {"source_hashes_fnv1a64", std::move(sources)}};
}

}  // namespace

void write_prepared_scene(const std::filesystem::path& folder, const Capture& scene) {
  ordered_json file{{"camera_model", "PINHOLE"}};
  if (scene.has_points) file["ply_file_path"] = "points.ply";
  file["tessera"] = tessera_json(scene);
  if (scene.by_reference) file["tessera"]["clips"] = clips_json(scene);
  ordered_json frames = ordered_json::array();
  if (!scene.by_reference)
    for (const CaptureFrame& frame : scene.frames) frames.push_back(frame_json(frame));
  file["frames"] = std::move(frames);
  write_text_file(folder / "transforms.json", json_text(file, 1) + "\n");
}

}  // namespace tessera
