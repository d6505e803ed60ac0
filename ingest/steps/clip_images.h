// The frames of a clip as a prepared scene has them, whether they are written or kept in memory.
#pragma once
#include <functional>
#include <vector>

#include "ingest/prepared/scene_clip.h"
#include "ingest/steps/prepared_image.h"
#include "ingest/video/clip.h"
#include "ingest/video/video_decoder.h"

namespace tessera {

/// Decodes the frames at `ticks`, increasing, and hands each over to `on_image` with its place in
/// `ticks`, from several threads; at most two images a thread wait. `on_decoded` is told each
/// before that, from the calling thread. Errors: as decode_clip; of the two.
void prepare_clip_images(const RigClip& clip, const std::vector<int64_t>& ticks,
                         const ImagePreparation& preparation,
                         const std::function<void(const VideoFrame&)>& on_decoded,
                         const std::function<void(size_t, Image8)>& on_image);

}  // namespace tessera
