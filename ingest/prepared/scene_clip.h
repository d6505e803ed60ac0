// A recording whose frames a prepared scene has by reference: they are decoded, and their lens is
// removed, when the scene is loaded.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ingest/poses/pinhole_view.h"
#include "ingest/scene.h"
#include "ingest/video/clip.h"

namespace tessera {

struct SceneClip {
  std::string camera;                        // its name
  std::vector<std::filesystem::path> files;  // whole paths: the video and its further chapters
  std::vector<int64_t> bytes;                // of each file
  std::vector<std::string> samples;          // sampled_hash of each; "": of an earlier version
  std::string hash;                          // of all of them (clip_hash)
  std::vector<ChapterStart> chapters{};      // one a further file
  Split split = Split::kTrain;
  Rational time_base;          // seconds a tick
  double time_offset = 0;      // seconds added to the camera's own clock
  std::vector<int64_t> ticks;  // of the frames of the scene, increasing
  Camera stored;               // of the images as the video has them, without pose
  Lens lens;
  std::string lens_model = "PINHOLE";
  FieldOfView field_of_view = FieldOfView::kValid;  // kFull or kValid
  double scale = 1;                                 // prepared size by stored size
  Camera prepared;                                  // of the scene's images, with its pose
  std::string mask_path;  // below the scene's folder, of all frames; empty: all pixels are used

  /// Seconds on the rig's clock.
  double seconds(int64_t ticks_of_frame) const {
    return time_base.at(ticks_of_frame) + time_offset;
  }
  /// "cam00/00017".
  std::string frame_name(int64_t number) const;
};

/// As an entry of `tessera.clips` in transforms.json. Ticks of a constant rate are one triple.
nlohmann::ordered_json to_json(const SceneClip& clip);
/// Errors: InputError: a file of the clip is gone, of another size, or another one.
void check_source(const SceneClip& clip);
/// Errors: InputError that starts with `where`, or as check_source.
SceneClip scene_clip_of(const nlohmann::json& entry, const std::string& where);

/// Reads frames of clips as a prepared scene has them. Threads may call it at once.
class ClipReader {
 public:
  virtual ~ClipReader() = default;
  /// Hands over the images at `ticks`, increasing, without lens distortion and scaled, RGB, with
  /// their place in `ticks`, in any order and from several threads. Errors: InputError naming the
  /// file: it is gone, or not what the scene was made from; as decode_frames.
  virtual void read(const SceneClip& clip, const std::vector<int64_t>& ticks,
                    const std::function<void(size_t, Image8)>& on_image) const = 0;
};

/// By FFmpeg; null in a build without it.
const ClipReader* video_clip_reader();

/// That of the program, which outlives all loading; null: none. Set once, before any scene is
/// loaded.
const ClipReader* clip_reader();
void set_clip_reader(const ClipReader* reader);

}  // namespace tessera
