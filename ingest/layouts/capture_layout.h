// Determines the layout of a capture folder, and lists its videos and image sequences.
#pragma once
#include <filesystem>
#include <vector>

#include "ingest/ingest.h"
#include "ingest/layouts/image_sequences.h"

namespace tessera {

/// The videos directly in `folder`, sorted by name.
std::vector<std::filesystem::path> videos_in(const std::filesystem::path& folder);

/// What `capture` is read as: what `options` state, else by its files and by where the poses are to
/// come from. Errors: as detect_layout, and where the stated poses do not fit what is there.
CaptureLayout layout_of(const std::filesystem::path& capture, const IngestOptions& options);

/// The word for it: "transforms", "n3dv", "colmap", …
const char* layout_name(CaptureLayout layout);
/// True where images lie in `capture` itself or in a folder images… directly below it.
bool has_images(const std::filesystem::path& capture);

/// The sequences of a capture that is read as kSequences: one a camera, or with kMoving one in all.
/// Errors: InputError: no images, or no two sequences with common numbers.
std::vector<ImageSequence> sequences_of(const std::filesystem::path& capture,
                                        std::optional<ImageReading> reading);

}  // namespace tessera
