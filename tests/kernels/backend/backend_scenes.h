// The random scenes on which all backends are compared, and the bounds for their images and
// gradients.
#pragma once
#include "tests/support/brute_force.h"
#include "tests/support/compare.h"
#include "tests/support/render.h"

namespace tessera::testing {

struct SceneCase {
  const char* name;
  int64_t fixed, moving;
  double size;  // world units; a pixel is about 0.1
  int degree;
  SetForm form = SetForm::kPair;  // of the moving ones
};

inline constexpr SceneCase kSceneCases[] = {
    {"static, degree 0", 150, 0, 0.15, 0},
    {"static, degree 3", 150, 0, 0.15, 3},
    {"dynamic, degree 1", 0, 150, 0.15, 1},
    {"dynamic, degree 3", 0, 150, 0.15, 3},
    {"mixed, degree 2", 90, 110, 0.15, 2},
    {"velocity, degree 1", 40, 110, 0.15, 1, SetForm::kVelocity},
    {"specks", 120, 120, 0.01, 3},
    {"splats larger than the image", 20, 20, 2.0, 3}};

inline TestScene<double> scene_of(const SceneCase& c, uint64_t seed) {
  TestScene<double> scene = random_scene(c.fixed, c.moving, c.size, seed, c.form);
  scene.options.sh_degree = c.degree;
  return scene;
}

inline void set_views(TestScene<double>& scene, std::vector<View> views, uint64_t seed) {
  Random random(seed);
  scene.views = std::move(views);
  fill_truth(scene, random);
}

/// Values nearer to a cut-off than this, relatively, may fall on either side of it.
inline constexpr double kCutoffBand = 1e-4;

/// Positions of up to 50 pixels are rounded to 4e-6 and ½ dᵀ conic d ≤ ln 255 has a gradient of at
/// most some 1/pixel for splats that matter; a device's exp is good to 2 + 1.2·ln 255 units in the
/// last place, 1e-6: α moves by some 1e-6 per splat, and a pixel sums a few. A pixel at a cut-off
/// may gain or lose one splat of α = 1/255, and one such pixel moves the mean of the smallest
/// image by up to 5e-6.
inline constexpr ImageBounds kPictureBounds{2e-5, 1.2 / 255, 0.02, 5e-6};

/// Sums of some 1000 pixels whose terms are exact to 1e-6 and partly cancel; behind nearly opaque
/// splats R/(1−α) multiplies rounding. A pixel at a cut-off may add or lose α = 1/255 of one splat,
/// which is up to a hundredth of the gradient of a small one.
inline constexpr GroupBounds kGradientBounds{2e-4, 2e-2, 0.005, 2e-4};

/// Pixels of each view of a scene at a cut-off.
inline std::vector<std::vector<bool>> critical_pixels(const TestScene<double>& scene) {
  std::vector<std::vector<bool>> masks;
  for (const View& view : scene.views)
    masks.push_back(render_brute(scene, view, kCutoffBand).critical);
  return masks;
}

/// Every view of a batch within the bounds.
inline void expect_batch(const std::vector<float>& colour, const std::vector<float>& transmittance,
                         const Rendered<double>& expected,
                         const std::vector<std::vector<bool>>& critical) {
  ASSERT_EQ(colour.size(), expected.colour.size());
  ASSERT_EQ(transmittance.size(), expected.transmittance.size());
  size_t first = 0;
  for (const std::vector<bool>& mask : critical) {
    const auto part = [&](const std::vector<double>& all, size_t planes) {
      const auto begin = all.begin() + ptrdiff_t(planes * first);
      return std::vector<double>(begin, begin + ptrdiff_t(planes * mask.size()));
    };
    expect_image(colour.data() + 3 * first, part(expected.colour, 3), mask, kPictureBounds,
                 "colour");
    expect_image(transmittance.data() + first, part(expected.transmittance, 1), mask,
                 kPictureBounds, "transmittance");
    first += mask.size();
  }
  EXPECT_EQ(first, transmittance.size());
}

/// Two tiles of the loss in each direction and a remainder, odd sizes, and one pixel alone.
inline TestScene<double> large_scene(uint64_t seed) {
  TestScene<double> scene = random_scene(60, 60, 0.3, seed);
  std::vector<View> views = five_views();
  views[0].camera = views[0].camera.resized(251, 67);
  views[1].camera = views[1].camera.resized(120, 36);
  set_views(scene, views, seed + 1);
  keep_truth_away(scene, seed + 2);
  return scene;
}

}  // namespace tessera::testing
