// A rolling shutter against its definition: each row of the image is that of a global shutter at
// the time of the row.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/render.h"
#include "tests/support/test_scene.h"

namespace tessera::testing {
namespace {

/// Small Gaussians that move by about a tenth of the image in a readout of 0.2.
TestScene<double> moving_scene(SetForm form) {
  TestScene<double> scene = random_scene(5, 40, 0.05, 61, form);
  for (double& s : scene.moving.group[kLogScaleTime]) s = 1;  // all that happens is motion
  return scene;
}

/// Rows of views with a global shutter, each at its own time.
std::vector<double> by_rows(TestScene<double> scene) {
  std::vector<double> composed;
  const std::vector<View> views = scene.views;
  for (const View& view : views) {
    const int width = view.camera.width, height = view.camera.height;
    const size_t first = composed.size();
    composed.resize(first + size_t(3 * width * height));
    for (int y = 0; y < height; ++y) {
      View at_row = view;
      at_row.camera.readout = 0;
      at_row.time = view.time + view.camera.readout * ((y + 0.5) / height - 0.5);
      scene.views = {at_row};
      const std::vector<double> image = render(scene).colour;
      for (int c = 0; c < 3; ++c)
        for (int x = 0; x < width; ++x) {
          const size_t i = size_t((c * height + y) * width + x);
          composed[first + i] = image[i];
        }
    }
  }
  return composed;
}

double mean_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / double(a.size());
}

TEST(RollingShutter, EachRowIsThatOfItsTime) {
  for (const SetForm form : kDynamicForms) {
    TestScene<double> scene = moving_scene(form);
    const std::vector<double> global = render(scene).colour;
    set_readouts(scene, 0.2);
    const std::vector<double> expected = by_rows(scene);
    EXPECT_LT(mean_difference(render(scene).colour, expected),
              0.25 * mean_difference(global, expected))
        << form_name(form);
  }
}

TEST(RollingShutter, WhatStandsStillDoesNotChange) {
  TestScene<double> scene = random_scene(40, 0, 0.1, 62);
  const std::vector<double> global = render(scene).colour;
  for (View& view : scene.views) view.camera.readout = 0.3;
  EXPECT_EQ(render(scene).colour, global);
}

}  // namespace
}  // namespace tessera::testing
