// The pixels and masks of the frames of a scene.
#pragma once
#include <filesystem>
#include <vector>

#include "ingest/prepared/scene_reader.h"
#include "ingest/prepared/transforms_json.h"

namespace tessera {

/// Whether a scene may have it as an image.
bool is_png(const std::filesystem::path& file);

/// Scene::frames from `frames`, in parallel, but for their times; and had_alpha. Those of clips are
/// decoded clip by clip. Errors: InputError, the first in the order of the frames: as load_scene,
/// of images, masks and clips.
void load_frames(const std::vector<TransformsFrame>& frames, const std::vector<SceneClip>& clips,
                 const SceneOptions& options, Scene& scene);

}  // namespace tessera
