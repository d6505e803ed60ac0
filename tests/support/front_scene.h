// A camera at the origin that looks along +z, with round Gaussians added before it one by one:
// scenes whose image is known in closed form.
#pragma once
#include "tests/support/render.h"

namespace tessera::testing {

inline constexpr int kFrontSize = 33;      // pixels, both ways
inline constexpr double kFrontFocal = 40;  // pixels
inline constexpr int kFrontMiddle = 16;    // the pixel whose centre is the principal point

inline double logit(double p) {
  return std::log(p / (1 - p));
}

inline View front_view(int width = kFrontSize, int height = kFrontSize) {
  View view;
  view.camera.width = width;
  view.camera.height = height;
  view.camera.fl_x = view.camera.fl_y = kFrontFocal;
  view.camera.cx = view.camera.cy = kFrontMiddle + 0.5;
  return view;
}

inline TestScene<float> front_scene() {
  TestScene<float> scene;
  scene.views = {front_view()};
  scene.truth = {std::vector<uint8_t>(3 * kFrontSize * kFrontSize, 77)};
  return scene;
}

/// Adds a round static Gaussian of deviation `size` and a colour that no direction changes.
inline void add_round(TestScene<float>& scene, std::array<double, 3> mean, double size,
                      double opacity, std::array<double, 3> colour) {
  TestGaussians<float>& set = scene.fixed;
  TestGaussians<float> grown(SetForm::kStatic, set.count + 1);
  for (int g = 0; g < kStaticGroups; ++g)
    std::copy(set.group[g].begin(), set.group[g].end(), grown.group[g].begin());
  const int64_t n = set.count;
  for (int i = 0; i < 3; ++i) {
    grown.at(kMean, n)[i] = float(mean[size_t(i)]);
    grown.at(kLogScale, n)[i] = float(std::log(size));
    grown.at(kSh, n)[i] = float((colour[size_t(i)] - 0.5) / kSh0);
  }
  grown.at(kRotation, n)[0] = 1;
  *grown.at(kOpacityLogit, n) = float(logit(opacity));
  scene.fixed = grown;
}

/// Channel c of the first view's pixel (x, y).
inline float front_pixel(const Rendered<float>& r, int c, int x, int y) {
  return r.colour[size_t((c * kFrontSize + y) * kFrontSize + x)];
}

}  // namespace tessera::testing
