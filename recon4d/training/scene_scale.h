// A scene with smaller images by area averages, as the multi-scale protocol trains and scores.
// Source: [Mip-Splatting], multi-scale evaluation.
#pragma once
#include "ingest/scene.h"

namespace tessera {

/// Mean of the area that each new pixel covers, per channel as stored, rounded to nearest.
/// `width`, `height`: at most the image's.
Image8 averaged_image(const Image8& image, int width, int height);
/// The same of the image's proportions, at most `width` wide; a narrower image stays as it is.
Image8 narrowed_image(const Image8& image, int width);
/// The same of the camera of an image: no side is longer than `longest`.
Camera limited_camera(const Camera& camera, int longest);

/// A frame at `scale` times its size, 0 < scale ≤ 1, as of scaled_scene.
Frame scaled_frame(const Frame& frame, double scale);
/// Images, masks and cameras of `scale` times their size, 0 < scale ≤ 1; sides are rounded to
/// nearest. A new pixel is used where the mask uses all of its area.
Scene scaled_scene(Scene scene, double scale);

/// A score at `scale` times the size that was trained on needs images of this size by the
/// scene's. Errors: InputError where the scene's images are smaller than that.
double truth_scale(double scale, double train_scale);

}  // namespace tessera
