// OpenImageIO, in a module that is loaded with the first image that needs it: its 260 libraries
// take longer to load than most commands work.
#pragma once
#include <string>

#include "ingest/images/image_source.h"

namespace tessera {

/// What the module has of an image: SourceImage without its conversion, which `icc`, the bytes of
/// its profile, asks for. Errors: InputError as of read_source_image; std::runtime_error: the
/// module is not where the program was built or installed.
SourceImage read_through_openimageio(const std::filesystem::path& file, std::string& icc);

}  // namespace tessera
