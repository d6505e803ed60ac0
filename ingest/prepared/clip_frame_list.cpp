// A frame is known by its clip and its ticks; its time follows from them as in `tessera ingest`.
#include "ingest/prepared/clip_frame_list.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;

TransformsFrame frame_of(const TransformsCapture& capture, int clip_index, size_t number,
                         const std::filesystem::path& mask, const std::string& where) {
  const SceneClip& clip = capture.clips[size_t(clip_index)];
  const TimeAxis& axis = *capture.prepared_axis;
  TransformsFrame frame;
  frame.where = where;
  frame.clip = clip_index;
  frame.ticks = clip.ticks[number];
  frame.mask = mask;
  frame.name = clip.frame_name(int64_t(number));
  frame.camera_name = clip.camera;
  frame.camera_is_stated = true;
  frame.frame_number = int64_t(number);
  frame.split = clip.split;
  frame.time =
      capture.prepared_static ? 0 : (clip.seconds(frame.ticks) - axis.origin) / axis.duration;
  frame.camera = clip.prepared;
  return frame;
}

}  // namespace

void add_clip_frames(const json& object, const std::filesystem::path& path,
                     TransformsCapture& capture) {
  const auto clips = object.find("clips");
  if (clips == object.end()) return;
  if (!clips->is_array())
    throw InputError(
        fmt::format("{}: tessera.clips is no list; prepare the capture again", path.string()));
  std::set<std::string> cameras;
  for (const json& entry : *clips) {
    const int index = int(capture.clips.size());
    const std::string where = fmt::format("{}, clip {}", path.string(), index);
    const SceneClip& clip = capture.clips.emplace_back(scene_clip_of(entry, where));
    if (!cameras.insert(clip.camera).second)
      throw InputError(fmt::format(
          "{}: there is another clip of camera {}; prepare the capture again", where, clip.camera));
    const std::filesystem::path mask =
        clip.mask_path.empty() ? "" : path.parent_path() / clip.mask_path;
    if (!mask.empty() && !std::filesystem::exists(mask))
      throw InputError(fmt::format("{}: no such mask as {}; restore it or take mask_path out",
                                   where, mask.string()));
    const std::string of_frames = fmt::format("{} ({})", where, clip.camera);
    for (size_t number = 0; number < clip.ticks.size(); ++number)
      capture.frames.push_back(frame_of(capture, index, number, mask, of_frames));
  }
}

}  // namespace tessera
