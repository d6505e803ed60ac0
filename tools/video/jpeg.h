// One 8-bit RGB image as a JPEG file in memory.
#pragma once
#include <optional>
#include <string>

#include "ingest/scene.h"

namespace tessera {

/// The bytes of a JFIF file without chroma subsampling; nothing in a build without FFmpeg, or with
/// one that has no JPEG encoder. `quantiser`: from 2 (best) to 31. The same image gives the same
/// bytes. `image` is RGB and not empty.
std::optional<std::string> jpeg_bytes(const Image8& image, int quantiser);

}  // namespace tessera
