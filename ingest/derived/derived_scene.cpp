// Entries of clips and of image files differ in where they state the name of a frame.
#include "ingest/derived/derived_scene.h"

#include <fmt/format.h>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "ingest/images/image_paths.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"

namespace tessera {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

void check_is_prepared(const fs::path& folder) {
  if (is_prepared_scene(folder)) return;
  throw InputError(
      fmt::format("{}: is no prepared scene; name a folder that `tessera ingest` has written",
                  folder.string()));
}

FrameEntries::FrameEntries(const ordered_json& file) {
  for (const ordered_json& clip : file["tessera"].value("clips", ordered_json::array()))
    of_camera_[clip["camera"]] = clip;
  for (const ordered_json& frame : file["frames"])
    of_name_[fs::path(frame["file_path"].get<std::string>()).replace_extension().string()] = frame;
}

ordered_json FrameEntries::image_entry(const Frame& frame) const {
  const auto listed = of_name_.find(frame.name);
  const ordered_json& known =
      listed != of_name_.end() ? listed->second : of_camera_.at(frame.camera_name);
  ordered_json entry{
      {"file_path", frame.name + ".png"}, {"split", name_of(frame.split)}, {"time", frame.time}};
  for (const char* key : {"w", "h", "fl_x", "fl_y", "cx", "cy", "transform_matrix", "mask_path"})
    if (known.contains(key)) entry[key] = known[key];
  entry["tessera"] = {{"camera", frame.camera_name}, {"frame", frame.frame_number}};
  return entry;
}

ordered_json description_of(ordered_json file, const Scene& scene) {
  ordered_json& object = file["tessera"];
  object.erase("clips");
  object["format_version"] = 1;
  if (scene.points.position.empty()) file.erase("ply_file_path");
  object["time"]["origin"] = scene.time_axis.origin;
  object["time"]["duration"] = scene.time_axis.duration;
  object["time"]["static"] = scene.is_static;
  file["frames"] = ordered_json::array();
  return file;
}

void copy_mask(const fs::path& from, ordered_json& entry, const fs::path& to) {
  const std::string mask = entry.value("mask_path", "");
  if (mask.empty()) return;
  const std::string name = name_of_image(mask) + fs::path(mask).extension().string();
  entry["mask_path"] = name;
  if (fs::exists(to / name)) return;
  make_folder((to / name).parent_path());
  write_text_file(to / name, read_text_file(from / mask));
}

}  // namespace tessera
