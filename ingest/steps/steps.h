// The steps of `ingest`, in their order (ingest_capture.cpp): each takes a capture and returns what
// it has made of it. A step to which a capture gives nothing to do returns it as it is.
#pragma once
#include <filesystem>

#include "ingest/capture/capture.h"
#include "ingest/ingest.h"

namespace tessera {

struct StepContext {
  const IngestOptions& options;         // `layout` and `work` are set
  const std::filesystem::path& folder;  // empty; images and descriptions are written there
  const IngestProgress& progress;       // never empty
};

/// Errors of all: as ingest_capture.
using Step = Capture(Capture capture, const StepContext& context);

/// Of clips: the poses that are stated, --cameras, timelines, held-out cameras. Clips whose pose is
/// missing or whose lens cannot be removed are left out; what lengths, rates and colours tell is
/// said before COLMAP has worked for minutes.
Step open_clips;
/// Of several clips without poses: one pose a camera, by COLMAP; those without one are left out.
Step pose_cameras;
/// Of photos without poses, and of one clip without: a pose a frame, by COLMAP. Frames of a clip
/// are image files afterwards, at most 300 without --fps, --duration and --frames, evenly.
Step pose_frames;
/// Of clips: how long their cameras read an image out.
Step state_readouts;
/// Of clips: one clock a camera.
Step align_clocks;
/// Of clips: the frames of the window that was asked for. Of frames with times: those of each
/// camera's first `frames` times.
Step choose_frames;
/// By --held-out and --test-every, or as the layout has it; image files that are not there are
/// left out afterwards, so that they do not change the split of others.
Step choose_splits;
/// Times become those of the scene, in [0, 1].
Step set_times;
/// Of --masks: the mask of each frame, instead of a stated one.
Step find_masks;
/// Undistorts, scales and writes images and masks. Cameras become those of the written images.
Step write_images;
/// Names frames without a mask where there are masks. Errors: InputError: no frame has one.
Step check_masks;
/// The points that lie beside the capture, or those of its known poses.
Step read_points;

/// World, exposure, initial cloud, the table of cameras: writes points.ply and transforms.json.
Step finish_scene;

}  // namespace tessera
