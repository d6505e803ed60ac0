// The precedence and the units of stated intrinsics.
#include "ingest/poses/intrinsics.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

template <class T>
std::optional<T> first_of(const std::optional<T>& one, const std::optional<T>& other) {
  return one ? one : other;
}

/// f = 0.5·W / tan(angle / 2)
double focal_of_angle(double angle, int side, const std::string& where) {
  if (!(angle > 0 && angle < std::numbers::pi))
    throw InputError(fmt::format(
        "{}: camera angle is {}, expected radians between 0 and pi; correct camera_angle_x", where,
        angle));
  return 0.5 * side / std::tan(0.5 * angle);
}

void check_focal(double focal, const char* key, const std::string& where) {
  if (std::isfinite(focal) && focal > 0) return;
  throw InputError(fmt::format("{}: {} is {}, expected a positive number of pixels; correct it",
                               where, key, focal));
}

}  // namespace

StatedIntrinsics StatedIntrinsics::or_else(const StatedIntrinsics& file) const {
  StatedIntrinsics merged = *this;
  if (!fl_x && !camera_angle_x) {
    merged.fl_x = file.fl_x;
    merged.camera_angle_x = file.camera_angle_x;
  }
  if (!fl_y && !camera_angle_y && !fl_x && !camera_angle_x) {
    merged.fl_y = file.fl_y;
    merged.camera_angle_y = file.camera_angle_y;
  }
  merged.cx = first_of(cx, file.cx);
  merged.cy = first_of(cy, file.cy);
  merged.w = first_of(w, file.w);
  merged.h = first_of(h, file.h);
  merged.readout = first_of(readout, file.readout);
  return merged;
}

bool same_shape(int width, int height, int other_width, int other_height) {
  // The larger image predicts the smaller one's height within the rounding of its two sides.
  if (width < other_width) return same_shape(other_width, other_height, width, height);
  const double predicted_height = double(height) * other_width / width;
  const double predicted_width = double(width) * other_height / height;
  return std::abs(predicted_height - other_height) <= 1.0 ||
         std::abs(predicted_width - other_width) <= 1.0;
}

void set_intrinsics(Camera& camera, const StatedIntrinsics& stated, int width, int height,
                    const std::string& where) {
  Camera in_stated_size = camera;
  in_stated_size.width = stated.w.value_or(width);
  in_stated_size.height = stated.h.value_or(height);
  const int w = in_stated_size.width, h = in_stated_size.height;
  if (w <= 0 || h <= 0 || !same_shape(w, h, width, height))
    throw InputError(fmt::format(
        "{}: states a size of {}x{}, the image is {}x{}; correct w and h, or use images of "
        "the same shape",
        where, w, h, width, height));
  if (!stated.fl_x && !stated.camera_angle_x)
    throw InputError(fmt::format(
        "{}: no focal length; add fl_x (pixels) or camera_angle_x (radians) to the file", where));
  in_stated_size.fl_x =
      stated.fl_x ? *stated.fl_x : focal_of_angle(*stated.camera_angle_x, w, where);
  if (stated.fl_y)
    in_stated_size.fl_y = *stated.fl_y;
  else if (!stated.fl_x && stated.camera_angle_y)
    in_stated_size.fl_y = focal_of_angle(*stated.camera_angle_y, h, where);
  else
    in_stated_size.fl_y = in_stated_size.fl_x;
  check_focal(in_stated_size.fl_x, "fl_x", where);
  check_focal(in_stated_size.fl_y, "fl_y", where);
  in_stated_size.cx = stated.cx.value_or(0.5 * w);
  in_stated_size.cy = stated.cy.value_or(0.5 * h);
  if (!std::isfinite(in_stated_size.cx) || !std::isfinite(in_stated_size.cy))
    throw InputError(fmt::format("{}: cx or cy is not finite; correct it", where));
  in_stated_size.readout = stated.readout.value_or(camera.readout);
  camera = in_stated_size.resized(width, height);
}

}  // namespace tessera
