// What: images as OpenCV's floats with the colours weighted by alpha, and back: what resampling
//       must average.
// Not: linear light, and not for headers of other folders: OpenCV stays in tessera_ingest_media.
#pragma once
#include <opencv2/core/mat.hpp>

#include "ingest/scene.h"

namespace tessera {

/// Floats of [0, 255]; RGBA colours are multiplied by alpha / 255, others as they are.
cv::Mat alpha_weighted(const Image8& image);
/// The inverse, rounded and saturated; colours without alpha are black. Divides in place.
Image8 without_alpha_weight(cv::Mat& pixels);

}  // namespace tessera
