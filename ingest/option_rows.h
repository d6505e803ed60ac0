// The options of ingest as commands have them, one row each, in the order of their help. ingest.h
// documents what they mean; tools/cli/ingest_arguments.cpp reads and records them.
#pragma once
#include "ingest/ingest.h"

namespace tessera {

/// visit(name, field, doc, what a record has for a number that is not given) for each option, in
/// the order of the help. `Options`: IngestOptions, to be changed or not.
template <class Options, class Visit>
void for_each_ingest_option(Options& o, Visit&& visit) {
  visit("--layout", o.image_layout,
        "how images are read: rig (several cameras that film together), photos (of a static "
        "scene), moving (one camera that moves); default: from their names");
  visit("--scale", o.scale, "image size relative to the source, above 0 to 1, or 50%");
  visit("--frames", o.frames, "use the first N timesteps of each camera; default: all");
  visit("--start", o.start, "videos: begin so many seconds after the first common timestep");
  visit("--duration", o.duration, "videos: use so many seconds; default: all");
  visit("--fps", o.fps,
        "videos: use so many frames per second; default: all. Image sequences: frame rate of "
        "the numbers; default: 30");
  visit("--cameras", o.cameras, "videos: use these cameras, by name; default: all");
  visit("--held-out", o.held_out,
        "test cameras (or photos), by name, or none; default: the innermost camera of a rig; for "
        "photos see --test-every");
  visit("--frames-as", o.frames_as,
        "videos of fixed cameras: png (an image a frame), video (frames are decoded from the "
        "source videos when the scene is loaded, and take no disk), or auto (video where the clip "
        "is longer than 20 s)");
  visit("--images", o.images,
        "photos: folder of the images, for example images_4; default: images");
  visit("--test-every", o.test_every,
        "photos, one moving camera, transforms files without test frames: every Nth image by name "
        "is a test view; 0: none; default: 8",
        -1);
  visit("--poses", o.poses.source,
        "source of the poses: n3dv or llff (poses_bounds.npy), colmap (an existing model, else "
        "estimated), or a file or folder of cameras; default: what the folder has");
  visit("--camera-model", o.poses.lens_model,
        "lens model that COLMAP estimates, for example OPENCV; default: the simplest that fits");
  visit("--intrinsics", o.poses.intrinsics,
        "estimated intrinsics: shared (by cameras of one image size) or per-camera");
  visit("--undistort", o.field_of_view,
        "view of images whose lens distortion is removed: valid (cropped until all pixels are "
        "valid), full (up to 120 degrees; blank pixels are masked), or auto (full where the crop "
        "would take more than a tenth)");
  visit("--sync", o.sync.method,
        "how the clocks of the cameras are aligned: auto, none, container, audio or motion");
  visit("--offsets", o.sync.offsets, "file of clock offsets in seconds by camera; replaces --sync");
  visit("--readout", o.readouts,
        "videos: time in which a rolling shutter reads an image from its top row to its bottom "
        "one, for example 16ms, or of single cameras cam01=16ms,cam02=-8ms");
  visit("--strict", o.strict,
        "treat a missing or unreadable image and a camera without a pose as errors");
  visit("--masks", o.masks,
        "folder of masks, named as the images or cameras; black pixels are ignored");
  visit("--invert-masks", o.invert_masks, "ignore white pixels instead of black ones");
  visit("--fit-exposure", o.fit_exposure,
        "divide each training camera's images by its gains, measured on features");
  visit("--keep-world", o.keep_world,
        "leave the poses' world as it is; default: up, centre and scale are normalised where the "
        "world is arbitrary (all but transforms)");
  visit(
      "--cloud", o.cloud,
      "initial points: none (nor in the training of `run`), sparse (the capture's, else COLMAP's), "
      "dense (and a plane sweep); "
      "default: dense where three training cameras share timesteps; none where frames stay in "
      "videos, as each training makes its own");
  visit("--cloud-points", o.cloud_points, "largest number of points of the plane sweep");
}

}  // namespace tessera
