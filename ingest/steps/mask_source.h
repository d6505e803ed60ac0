// The masks of a capture: reads any image format and brings them to the camera and the size of
// their images. Resampled masks are cut at one half.
#pragma once
#include <atomic>
#include <cstdint>
#include <filesystem>

#include "ingest/capture/capture.h"
#include "ingest/ingest.h"
#include "ingest/poses/lens.h"
#include "ingest/scene.h"

namespace tessera {

/// Reads the mask of an image of width × height, or of one of the same shape that was larger;
/// turned with options.invert_masks. Masks of object numbers are counted. Errors: InputError naming
/// the file.
Image8 read_mask(const std::filesystem::path& file, int width, int height,
                 const IngestOptions& options, std::atomic<int64_t>& object_masks);
/// All pixels are used.
Image8 whole_mask(int width, int height);
/// A line about so many masks of object numbers; none without any.
void note_object_masks(int64_t count, Capture& capture);
/// As Undistortion::apply; what lies beyond the image is ignored.
Image8 undistorted_mask(const Image8& mask, const Camera& camera, const Lens& lens,
                        const Camera& pinhole);
/// Scaled as the images are.
Image8 scaled_mask(const Image8& mask, double scale);

}  // namespace tessera
