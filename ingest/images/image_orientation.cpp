// What: the eight orders of pixels as a source index each.
// Not: resampling: pixels are moved only.  Source: EXIF 2.32, tag 0x0112.
#include "ingest/images/image_orientation.h"

#include <algorithm>

#include "ingest/poses/intrinsics.h"
#include "kernels/base/errors.h"

namespace tessera {

Image8 turned_upright(const Image8& stored, int orientation) {
  check(orientation >= 1 && orientation <= 8, "EXIF orientation");
  const bool sides_swapped = orientation >= 5;
  const int w = stored.width, h = stored.height;
  Image8 upright{sides_swapped ? h : w, sides_swapped ? w : h, stored.channels, {}};
  upright.data.reserve(stored.data.size());
  // The tag says where row 0 and column 0 of the stored image lie in the upright one.
  const bool from_right =
      orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_below =
      orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  for (int y = 0; y < upright.height; ++y)
    for (int x = 0; x < upright.width; ++x) {
      int column = sides_swapped ? y : x, row = sides_swapped ? x : y;
      if (from_right) column = w - 1 - column;
      if (from_below) row = h - 1 - row;
      const auto scalar = (ptrdiff_t(row) * w + column) * stored.channels;
      upright.data.insert(upright.data.end(), stored.data.begin() + scalar,
                          stored.data.begin() + scalar + stored.channels);
    }
  return upright;
}

Image8 image_as_posed(SourceImage source, int width, int height, bool& doubtful) {
  if (source.orientation == 1) return std::move(source.image);
  const int w = source.image.width, h = source.image.height;
  const bool sides_swapped = source.orientation >= 5;
  const bool as_stored = same_shape(width, height, w, h);
  const bool upright = sides_swapped ? same_shape(width, height, h, w) : as_stored;
  if (upright && !as_stored) return turned_upright(source.image, source.orientation);
  doubtful = doubtful || upright;
  return std::move(source.image);
}

}  // namespace tessera
