// What: PreparedScene → transforms.json in the Nerfstudio convention with a `tessera` object.
// Not: a place for decisions: everything written here was decided by the converter.
#include "ingest/prepared_scene.h"

#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/pose_matrix.h"

namespace tessera {
namespace {

using nlohmann::ordered_json;

ordered_json rational_json(const Rational& value) {
  return ordered_json::array({value.numerator, value.denominator});
}

ordered_json frame_json(const PreparedFrame& prepared) {
  const Frame& frame = prepared.frame;
  const Camera& camera = frame.camera;
  ordered_json matrix = ordered_json::array();
  for (const auto& row : gl_pose_of(camera)) matrix.push_back(row);
  matrix.push_back({0.0, 0.0, 0.0, 1.0});
  ordered_json tessera{{"camera", frame.camera_name}, {"frame", frame.frame_number}};
  if (prepared.ticks) tessera["ticks"] = *prepared.ticks;
  constexpr const char* kSplitNames[] = {"train", "val", "test"};
  return {{"file_path", prepared.file_path},
          {"split", kSplitNames[int(frame.split)]},
          {"time", frame.time},
          {"w", camera.width},
          {"h", camera.height},
          {"fl_x", camera.fl_x},
          {"fl_y", camera.fl_y},
          {"cx", camera.cx},
          {"cy", camera.cy},
          {"transform_matrix", std::move(matrix)},
          {"tessera", std::move(tessera)}};
}

ordered_json tessera_json(const PreparedScene& scene) {
  ordered_json cameras = ordered_json::array(), sources = ordered_json::object();
  for (const PreparedCamera& camera : scene.cameras) {
    cameras.push_back({{"name", camera.name},
                       {"time_base", rational_json(camera.time_base)},
                       {"time_offset", camera.time_offset}});
    if (camera.exposure_gain) cameras.back()["exposure_gain"] = *camera.exposure_gain;
  }
  for (const SourceFile& source : scene.sources) sources[source.name] = source.hash;
  const ordered_json identity = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  return {{"format_version", 1},
          {"layout", scene.layout},
          {"applied",
           {{"scale", scene.scale},
            {"undistortion", scene.undistortion},
            {"crop", "none"},
            {"world_transform", identity},
            {"background", scene.background}}},
          {"time",
           {{"base", rational_json(scene.time_base)},
            {"origin", scene.time_axis.origin},
            {"duration", scene.time_axis.duration},
            {"static", scene.is_static}}},
          {"cameras", std::move(cameras)},
          {"source_hashes_fnv1a64", std::move(sources)}};
}

}  // namespace

void write_prepared_scene(const std::filesystem::path& folder, const PreparedScene& scene) {
  ordered_json file{{"camera_model", "PINHOLE"}};
  if (scene.has_points) file["ply_file_path"] = "points.ply";
  file["tessera"] = tessera_json(scene);
  ordered_json frames = ordered_json::array();
  for (const PreparedFrame& frame : scene.frames) frames.push_back(frame_json(frame));
  file["frames"] = std::move(frames);
  write_text_file(folder / "transforms.json", file.dump(1) + "\n");
}

}  // namespace tessera
