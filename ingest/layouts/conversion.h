// The converters behind ingest_capture. Each fills an empty folder with the images of a prepared
// scene; finish_scene then writes its description.
#pragma once
#include <filesystem>
#include <functional>

#include "ingest/colmap/colmap_model.h"
#include "ingest/ingest.h"
#include "ingest/prepared/prepared_scene.h"

namespace tessera {

struct RigClip;

/// What a converter found and wrote. Images lie in the folder already; transforms.json and
/// points.ply are written from this (capture_conversion.cpp), after what holds for all layouts.
struct Converted {
  PreparedScene scene;
  PointCloud points;  // initial cloud in the capture's world; may be empty
  IngestReport report;
};

using Converter = Converted(const std::filesystem::path& capture,
                            const std::filesystem::path& folder, const IngestOptions& options,
                            const IngestProgress& progress);
// Errors of all: as ingest_capture.
Converter convert_videos;       // one video a camera; poses are stated or estimated
Converter convert_transforms;   // images listed in transforms*.json
Converter convert_colmap;       // photos posed by a COLMAP model; a static scene
Converter convert_llff;         // photos beside poses_bounds.npy, a row each; a static scene
Converter convert_bare_photos;  // photos without poses, which COLMAP estimates; a static scene

/// The images of `model` below `images` as a static scene; its `layout` is the caller's to
/// name.
Converted convert_photos(const std::filesystem::path& capture, const std::filesystem::path& images,
                         ColmapModel model, const std::filesystem::path& folder,
                         const IngestOptions& options, const IngestProgress& progress);

/// Calls `convert` for each image, in parallel, chunk by chunk, so that progress comes from the
/// calling thread and can stop the conversion. Errors: the InputError of the first image.
void convert_images(size_t count, const IngestProgress& progress,
                    const std::function<void(size_t)>& convert);
/// The camera of an image scaled by `scale`; its rays are those of the original.
Camera scaled_camera(const Camera& camera, double scale);
/// Scales `image` and writes it as an RGB or RGBA PNG (grey becomes RGB).
void write_prepared_image(const std::filesystem::path& path, Image8 image, double scale);

/// Writes points.ply and transforms.json into `folder`, which holds the images. Errors:
/// InputError.
void finish_scene(Converted& converted, CaptureLayout layout, const std::filesystem::path& folder,
                  const IngestOptions& options, const IngestProgress& progress);

/// `clip` has no pose. Without --fps, --duration or --frames at most 300 frames are taken, evenly.
/// Times are the frames' own; every 8th frame is for the test (options.test_every). Errors: as
/// ingest_capture.
Converted convert_moving_video(const std::filesystem::path& capture, const RigClip& clip,
                               const std::filesystem::path& folder, const IngestOptions& options,
                               const IngestProgress& progress);

}  // namespace tessera
