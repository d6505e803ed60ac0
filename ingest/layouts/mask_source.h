// Converts the masks of a capture to those of a prepared scene: finds them by name, reads any image
// format, undistorts and scales them as their images, and writes them below masks/. Resampled masks
// are cut at one half.
#pragma once
#include <filesystem>
#include <string>

#include "ingest/ingest.h"
#include "ingest/poses/lens.h"
#include "ingest/prepared/prepared_scene.h"

namespace tessera {

/// The mask of an image below `options.masks`: for "a/b.jpg" a/b.png, a/b.jpg.png, else a/b with
/// another extension of images; for a camera's videos its name. Empty when there is none.
std::filesystem::path find_mask(const IngestOptions& options, const std::filesystem::path& image);

/// Reads the mask of an image of width × height, or of one of the same shape that was larger;
/// turned with options.invert_masks. An empty `file` gives an empty mask, as do the two functions
/// below for one. Errors: InputError naming the file.
Image8 read_mask(const std::filesystem::path& file, int width, int height,
                 const IngestOptions& options);
/// As Undistortion::apply; what lies beyond the image is ignored.
Image8 undistorted_mask(const Image8& mask, const Camera& camera, const Lens& lens,
                        const Camera& pinhole);
/// Scales and writes masks/`name`.png below `folder`; returns that path, below `folder`.
std::string write_prepared_mask(const std::filesystem::path& folder, const std::string& name,
                                const Image8& mask, double scale);

/// What all frames of a camera's video share: the functions above in their order. Returns the
/// frames' PreparedFrame::mask_path, empty where `options.masks` has none of that camera.
std::string prepare_camera_mask(const std::filesystem::path& folder, const std::string& camera_name,
                                const Camera& camera, const Lens& lens, const Camera& pinhole,
                                const IngestOptions& options);

/// Errors: InputError when masks or their inversion were requested and no frame has one. A warning
/// names how many frames have none.
void check_masks(const PreparedScene& scene, const IngestOptions& options, IngestReport& report);

}  // namespace tessera
