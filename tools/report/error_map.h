// The error of a rendered image as colours, with one fixed scale for all images.
#pragma once
#include <string>

#include "ingest/scene.h"

namespace tessera {

/// The error that has the last colour of the scale, in 1/255.
constexpr int kLargestShownError = 32;

/// The mean absolute difference of the three channels of every pixel, from 0 (black) to
/// kLargestShownError and above (pale yellow). Pixels that the mask of the frame ignores are grey;
/// a mask without data uses all. Images are RGB and of one size.
Image8 error_map(const Image8& drawn, const Image8& truth, const Image8& mask);

/// The same scale as a gradient of CSS, from left to right.
std::string error_scale_css();

}  // namespace tessera
