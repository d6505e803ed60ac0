// The intrinsics that a transforms.json states, for the file and for a frame, and their conversion
// to an image of a given size.
#pragma once
#include <optional>
#include <string>

#include "kernels/base/camera.h"

namespace tessera {

/// Values as stated; those of a frame win over those of the file (`or_else`).
struct StatedIntrinsics {
  std::optional<double> fl_x, fl_y, cx, cy;              // pixels of a w × h image
  std::optional<double> camera_angle_x, camera_angle_y;  // radians, full field of view
  std::optional<int> w, h;                               // pixels
  std::optional<double> readout;                         // Camera::readout, seconds

  /// The values of this level, and those of `file` where this level has none. A level's focal
  /// length and angle go together: an angle stated here beats a focal length stated there.
  StatedIntrinsics or_else(const StatedIntrinsics& file) const;
};

/// Sets size and intrinsics of `camera` for an image of width × height. Stated for another size of
/// the same shape (within a pixel), they are scaled, so rays do not change. Errors: InputError that
/// starts with `where`: no focal length, a value that is not positive, another shape.
void set_intrinsics(Camera& camera, const StatedIntrinsics& stated, int width, int height,
                    const std::string& where);

/// True where two image sizes have the same shape within a pixel.
bool same_shape(int width, int height, int other_width, int other_height);

}  // namespace tessera
