// Scenes are read without pixels.
#include "tools/windows/cut_for_run.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "ingest/prepared/scene_reader.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"
#include "tools/live/earlier_training.h"
#include "tools/session/device_choice.h"
#include "tools/session/run_folder.h"

namespace tessera {
namespace {

/// Windows of the training on `files` that a folder holds; 0: none is there.
int64_t windows_there(const std::filesystem::path& run, const std::filesystem::path& scene,
                      const std::string& files) {
  const RunRecord record = record_of(RunFolder{run}, scene);
  if (!record.has_checkpoint && !record.has_model) return 0;
  if (!record.request.is_object() || record.request.value(kSceneFiles, files) != files) return 0;
  return record.request.value(kWindows, int64_t{1});
}

}  // namespace

WindowChoice cut_for_run(const std::string& windows, const std::filesystem::path& scene,
                         const std::string& files, Motion motion, const std::filesystem::path& run,
                         int64_t programs) {
  const WindowWish wish = parse_windows(windows);
  if (wish.kind == WindowWish::Kind::kNone) return {};
  if (motion == Motion::kNone) {
    if (wish.kind == WindowWish::Kind::kLength)
      throw InputError(fmt::format(
          "--windows {}: windows have what moves, and --static (--motion none) has nothing that "
          "does; leave one of them out",
          windows));
    return {};
  }
  if (wish.kind == WindowWish::Kind::kAuto && wish.seconds == 0)
    if (const int64_t count = windows_there(run, scene, files); count > 0) return {count, ""};
  const WindowChoice choice =
      choose_windows(wish, scene_without_pixels(scene, true), machine_memory() / programs);
  if (choice.count <= 1 || is_prepared_scene(scene)) return choice;
  const std::string reason =
      "its times may be numbers of frames: `tessera ingest` has not prepared it";
  if (wish.kind == WindowWish::Kind::kLength)
    throw InputError(
        fmt::format("--windows {}: {}: {}; prepare it first", windows, scene.string(), reason));
  return {1, whole_clip_text(reason)};
}

}  // namespace tessera
