// What: EXIF orientation: turning an image upright, and which order of pixels a pose belongs to.
// Not: reading the tag (image_source.h).
#pragma once
#include "ingest/images/image_source.h"

namespace tessera {

/// As a viewer shows it. Orientation 1 to 8 of EXIF: 2 mirrored, 3 turned by 180°, 4 flipped, 6
/// turned clockwise, 8 anticlockwise, 5 and 7 the mirrored ones of those.
Image8 turned_upright(const Image8& stored, int orientation);

/// The pixels that a camera of `width` × `height` (of any size of the same shape) describes: as
/// stored or turned upright, by the shape. Where both fit, as stored, because COLMAP (3.8) and the
/// field's loaders do not look at the tag; `doubtful` then becomes true. Where neither fits: as
/// stored.
Image8 image_as_posed(SourceImage source, int width, int height, bool& doubtful);

}  // namespace tessera
