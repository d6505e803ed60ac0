// The masks of a capture: finds them by name, reads any image format, and brings them to the camera
// and the size of their images. Resampled masks are cut at one half.
#pragma once
#include <filesystem>

#include "ingest/ingest.h"
#include "ingest/poses/lens.h"
#include "ingest/scene.h"

namespace tessera {

/// The mask of an image below `options.masks`: for "a/b.jpg" a/b.png, a/b.jpg.png, else a/b with
/// another extension of images; for a camera's videos its name. Empty when there is none.
std::filesystem::path find_mask(const IngestOptions& options, const std::filesystem::path& image);

/// Reads the mask of an image of width × height, or of one of the same shape that was larger;
/// turned with options.invert_masks. Errors: InputError naming the file.
Image8 read_mask(const std::filesystem::path& file, int width, int height,
                 const IngestOptions& options);
/// As Undistortion::apply; what lies beyond the image is ignored.
Image8 undistorted_mask(const Image8& mask, const Camera& camera, const Lens& lens,
                        const Camera& pinhole);
/// Scaled as the images are.
Image8 scaled_mask(const Image8& mask, double scale);

}  // namespace tessera
