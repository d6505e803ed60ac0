// The search for depths and for what moves, on a device: the same as math/ray_search.h and
// math/patch.h say, for many pixels at once. The CPU's is that of ingest/cloud.
#pragma once
#include <vector>

#include "kernels/math/ray_search.h"

namespace tessera {

class PixelSearch {
 public:
  virtual ~PixelSearch() = default;
  /// Copies the images, all in the host's memory; grey ones are made here. Those at other times
  /// (SearchView::sights) stay until this ends and must not change meanwhile. A view without an
  /// image is not searched. Errors: DeviceError where they do not fit.
  virtual void set_views(const std::vector<SearchView>& views, const DepthRange& range) = 0;
  /// Of each query. Waits.
  virtual std::vector<RayDepth> depths(const std::vector<RayQuery>& queries) = 0;
  /// Whether each pixel moves (SearchView::moves). Waits.
  virtual std::vector<uint8_t> moves(const std::vector<ViewPixel>& pixels) = 0;
};

}  // namespace tessera
