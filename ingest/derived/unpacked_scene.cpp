// Loads and writes as many frames at a time as threads have something to do with.
#include "ingest/derived/unpacked_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "ingest/derived/derived_scene.h"
#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "ingest/files/json_file.h"
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

void write_images(const fs::path& folder, const std::vector<Frame>& frames) {
  parallel_for(int64_t(frames.size()), 1, [&](int64_t begin, int64_t end) {
    for (auto i = size_t(begin); i < size_t(end); ++i)
      write_png(folder / (frames[i].name + ".png"), frames[i].image);
  });
}

}  // namespace

int64_t unpack_scene(const fs::path& folder, const std::optional<Window>& window,
                     const fs::path& out, const std::function<void(int64_t, int64_t)>& progress) {
  check_is_prepared(folder);
  const SceneFiles files(folder, true, window);
  SceneOptions options;
  options.load_pixels = false;
  const Scene scene = files.load(options);
  const auto count = int64_t(scene.frames.size());
  StagedFolder staged(out, is_prepared_scene(out), files_of_scene(out));
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
  write_text_file(staged.path() / "transforms.json", json_text(file, 1) + "\n");
  staged.commit();
  return count;
}

}  // namespace tessera
