// Loads and writes as many frames at a time as threads have something to do with.
#include "ingest/prepared/unpacked_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "ingest/files/png.h"
#include "ingest/files/point_cloud.h"
#include "ingest/prepared/scene_reader.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// What the file of the scene says of each frame but its time: of its clip, or of the frame itself.
class FrameEntries {
 public:
  explicit FrameEntries(const ordered_json& file) {
    for (const ordered_json& clip : file["tessera"].value("clips", ordered_json::array()))
      of_camera_[clip["camera"]] = clip;
    for (const ordered_json& frame : file["frames"])
      of_name_[fs::path(frame["file_path"].get<std::string>()).replace_extension().string()] =
          frame;
  }

  /// As an image file. Numbers are those of the file, so that they come back to the bit.
  ordered_json image_entry(const Frame& frame) const {
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

 private:
  std::map<std::string, ordered_json> of_camera_, of_name_;
};

/// What is not about frames, for those of `scene`.
ordered_json description_of(ordered_json file, const Scene& scene) {
  ordered_json& object = file["tessera"];
  object.erase("clips");
  object["format_version"] = 1;
  if (scene.points.position.empty()) file.erase("ply_file_path");
  object["time"]["origin"] = scene.time_axis.origin;
  object["time"]["duration"] = scene.time_axis.duration;
  file["frames"] = ordered_json::array();
  return file;
}

void write_images(const fs::path& folder, const std::vector<Frame>& frames) {
  parallel_for(int64_t(frames.size()), 1, [&](int64_t begin, int64_t end) {
    for (auto i = size_t(begin); i < size_t(end); ++i)
      write_png(folder / (frames[i].name + ".png"), frames[i].image);
  });
}

void copy_mask(const fs::path& from, const ordered_json& entry, const fs::path& to) {
  const std::string mask = entry.value("mask_path", "");
  if (mask.empty() || fs::exists(to / mask)) return;
  make_folder((to / mask).parent_path());
  write_text_file(to / mask, read_text_file(from / mask));
}

}  // namespace

int64_t unpack_scene(const fs::path& folder, const std::optional<Window>& window,
                     const fs::path& out, const std::function<void(int64_t, int64_t)>& progress) {
  if (!is_prepared_scene(folder))
    throw InputError(
        fmt::format("{}: is no prepared scene; name a folder that `tessera ingest` has written",
                    folder.string()));
  const SceneFiles files(folder, true, window);
  SceneOptions options;
  options.load_pixels = false;
  const Scene scene = files.load(options);
  const auto count = int64_t(scene.frames.size());
  StagedFolder staged(out, is_prepared_scene(out));
  const ordered_json source = ordered_json::parse(read_text_file(folder / "transforms.json"));
  const FrameEntries entries(source);
  ordered_json file = description_of(source, scene);
  options.load_pixels = true;
  const int64_t chunk = 4 * int64_t(thread_count());
  for (int64_t start = 0; start < count; start += chunk) {
    std::vector<int>& places = options.frames.emplace();
    for (int64_t i = start; i < std::min(start + chunk, count); ++i) places.push_back(int(i));
    const std::vector<Frame> frames = files.load(options).frames;
    write_images(staged.path(), frames);
    for (const Frame& frame : frames) {
      file["frames"].push_back(entries.image_entry(frame));
      copy_mask(folder, file["frames"].back(), staged.path());
    }
    progress(std::min(start + chunk, count), count);
  }
  if (!scene.points.position.empty()) write_points(staged.path() / "points.ply", scene.points);
  write_text_file(staged.path() / "transforms.json", file.dump(1) + "\n");
  staged.commit();
  return count;
}

}  // namespace tessera
