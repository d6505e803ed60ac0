// The pinhole camera whose image is resampled from that of a camera with a lens.
#pragma once
#include <string>

#include "ingest/ingest.h"
#include "ingest/poses/lens.h"

namespace tessera {

inline constexpr double kFarthestRay = 12;  // with z = 1; 85 degrees

/// The length of the shortest ray (z = 1) of a pixel: 0 where the axis meets the image.
double shortest_ray(const Camera& camera);

struct PinholeView {
  Camera camera;  // of the pose of the camera with the lens
  FieldOfView kept = FieldOfView::kValid;
  bool has_blanks = false;  // some of its pixels are shown by none of the image
};

/// Errors: InputError that starts with `where`: no such camera, because the distortion turns back
/// on itself within the image.
PinholeView pinhole_view(const Camera& camera, const Lens& lens, FieldOfView kept,
                         const std::string& where);

}  // namespace tessera
