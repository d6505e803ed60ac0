// Small scenes for tests: owned parameters of both sets, cameras, ground truth; and random scenes.
#pragma once
#include <glm/geometric.hpp>
#include <vector>

#include "kernels/batch.h"
#include "kernels/gaussians.h"
#include "kernels/math/colour_map.h"
#include "tests/support/forms.h"
#include "tests/support/random.h"

namespace tessera::testing {

/// Owned parameters (or gradients, or moments) of a set of Gaussians.
template <class Real>
struct TestGaussians {
  SetForm form;
  int64_t count;
  int coefficients, time_levels;
  std::vector<Real> group[kGroupCount];
  std::vector<Real> filter_size;  // [N] φ of the 3D filter; empty: none
  ShBlocks blocks;                // where rows differ in K

  explicit TestGaussians(SetForm f = SetForm::kStatic, int64_t n = 0, int k = 16, int levels = 0,
                         const ShBlocks& of_rows = {})
      : form(f), count(n), coefficients(k), time_levels(levels), blocks(of_rows) {
    for (int g = 0; g < group_count(form); ++g) {
      const bool ragged = blocks.mixed() && (g == kSh || g == kShTime);
      const int64_t scalars = ragged ? blocks.coefficients() * group_width(Group(g), 1, f, levels)
                                     : n * width(Group(g));
      group[g].assign(size_t(scalars), Real(0));
    }
  }
  int dim() const { return dim_of(form); }
  int width(Group g) const { return group_width(g, coefficients, form, time_levels); }
  Real* at(Group g, int64_t n) { return group[g].data() + n * width(g); }
  const Real* at(Group g, int64_t n) const { return group[g].data() + n * width(g); }
  GaussianSpans<Real> spans() { return make<Real>(*this); }
  GaussianSpans<const Real> view() const { return make<const Real>(*this); }

  template <class To>
  TestGaussians<To> as() const {
    TestGaussians<To> to(form, count, coefficients, time_levels, blocks);
    for (int g = 0; g < kGroupCount; ++g) to.group[g].assign(group[g].begin(), group[g].end());
    to.filter_size.assign(filter_size.begin(), filter_size.end());
    return to;
  }
  /// Gaussians of this set in the order `index`.
  TestGaussians select(const std::vector<int64_t>& index) const {
    TestGaussians to(form, int64_t(index.size()), coefficients, time_levels);
    for (int g = 0; g < group_count(form); ++g)
      for (size_t i = 0; i < index.size(); ++i)
        std::copy_n(at(Group(g), index[i]), width(Group(g)), to.at(Group(g), int64_t(i)));
    for (const int64_t i : index)
      if (!filter_size.empty()) to.filter_size.push_back(filter_size[size_t(i)]);
    return to;
  }

 private:
  template <class T, class Self>
  static GaussianSpans<T> make(Self& self) {
    GaussianSpans<T> s;
    s.form = self.form;
    s.count = self.count;
    s.coefficients = self.coefficients;
    s.time_levels = self.time_levels;
    s.blocks = self.blocks;
    for (int g = 0; g < kGroupCount; ++g)
      s.group[g] = {self.group[g].data(), int64_t(self.group[g].size())};
    s.filter_size = {self.filter_size.data(), int64_t(self.filter_size.size())};
    return s;
  }
};

}  // namespace tessera::testing

#include "tests/support/test_nodes.h"  // of the sets above

namespace tessera::testing {

template <class Real>
struct TestScene {
  TestGaussians<Real> fixed{SetForm::kStatic}, moving{SetForm::kPair};
  std::vector<View> views;
  std::vector<std::vector<uint8_t>> truth;  // [B] each [height, width, 3]
  RenderOptions options;
  LossWeights weights;
  std::vector<std::vector<uint8_t>> mask;  // [B] each [height, width] or empty; none: no masks
  RegulariserWeights regulariser;          // of `backward` alone
  std::vector<ColourMap<double>> maps;     // [B] of the loss; none: the images as rendered
  int environment_height = 0;              // H; 0: there is none
  std::vector<Real> environment = {};      // [H, 2H, 3]
  TestNodes<Real> nodes = {};              // of a canonical `fixed`
  double acceleration = 0;                 // of `backward` alone
  double length_share = 0;                 // of the statistics of `backward`

  template <class To>
  TestScene<To> as() const {
    return {fixed.template as<To>(),
            moving.template as<To>(),
            views,
            truth,
            options,
            weights,
            mask,
            regulariser,
            maps,
            environment_height,
            std::vector<To>(environment.begin(), environment.end()),
            nodes.template as<To>(),
            acceleration,
            length_share};
  }
};

/// A camera at `eye` that looks at `target`; world +y is up.
inline Camera look_at(const glm::dvec3& eye, const glm::dvec3& target, int width, int height,
                      double focal) {
  const glm::dvec3 forward = glm::normalize(target - eye);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 1, 0)));
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fl_x = focal;
  camera.fl_y = 1.1 * focal;
  camera.cx = 0.48 * width;
  camera.cy = 0.53 * height;
  camera.cam_from_world = glm::transpose(glm::dmat3(right, glm::cross(forward, right), forward));
  camera.translation = -(camera.cam_from_world * eye);
  return camera;
}

/// Gaussians in a ball of radius `spread` about the origin, sizes around `size`, all parameters
/// random; dynamic ones around the middle of the clip with a clear velocity.
inline TestGaussians<double> random_gaussians(SetForm form, int64_t count, double spread,
                                              double size, Random& random, int coefficients = 16) {
  TestGaussians<double> set(form, count, coefficients);
  const auto fill = [&](Group g, double low, double high) {
    for (double& x : set.group[g]) x = random.uniform(low, high);
  };
  fill(kMean, -spread, spread);
  fill(kLogScale, std::log(size) - 0.7, std::log(size) + 0.7);
  fill(kRotation, -1, 1);
  fill(kOpacityLogit, -1.5, 2);
  fill(kSh, -0.3, 0.3);
  if (form == SetForm::kStatic) return set;
  fill(kMeanTime, 0.2, 0.8);
  fill(kLogScaleTime, std::log(0.3), std::log(0.8));
  if (form == SetForm::kVelocity) {
    fill(kVelocity, -0.4, 0.4);
    return set;
  }
  for (int64_t n = 0; n < count; ++n)  // near the conjugate of the left one: moderate velocities
    for (int k = 0; k < 4; ++k)
      set.at(kRotationRight, n)[k] =
          (k == 0 ? 1 : -1) * set.at(kRotation, n)[k] + random.uniform(-0.15, 0.15);
  return set;
}

/// Gives a dynamic set levels of time, so strong that they show.
inline void add_time_levels(TestGaussians<double>& set, int levels, uint64_t seed) {
  Random random(seed);
  set.time_levels = levels;
  set.group[kShTime].resize(size_t(set.count * set.width(kShTime)));
  for (double& x : set.group[kShTime]) x = random.uniform(-0.2, 0.2);
}

/// The dynamic set that shows what a static one does: r = conj(l) and a long life.
inline TestGaussians<double> lifted(const TestGaussians<double>& fixed, double log_scale_time) {
  TestGaussians<double> set(SetForm::kPair, fixed.count, fixed.coefficients);
  for (int g = 0; g < kStaticGroups; ++g) set.group[g] = fixed.group[g];
  for (int64_t n = 0; n < fixed.count; ++n) {
    for (int k = 0; k < 4; ++k)
      set.at(kRotationRight, n)[k] = (k == 0 ? 1 : -1) * fixed.at(kRotation, n)[k];
    *set.at(kLogScaleTime, n) = log_scale_time;
    *set.at(kMeanTime, n) = 0.5;
  }
  return set;
}

/// Three views of different sizes, none a multiple of a tile, around the origin.
inline std::vector<View> three_views() {
  return {{look_at({0.3, 0.5, -4}, {0, 0, 0}, 37, 29, 45), 0.35},
          {look_at({3.5, -0.4, -1.5}, {0.1, 0, 0}, 24, 35, 38), 0.6},
          {look_at({-2.5, 1.5, 3}, {0, 0.1, 0}, 45, 18, 42), 0.5}};
}

/// Two more: one tile exactly, and a single pixel.
inline std::vector<View> five_views() {
  std::vector<View> views = three_views();
  views.push_back({look_at({0.2, -3, 2}, {0, 0, 0.1}, 16, 16, 15), 0.45});
  views.push_back({look_at({1, 0.3, -4}, {0, 0, 0}, 1, 1, 2), 0.4});
  return views;
}

/// Ground truth of noise for every view.
template <class Real>
void fill_truth(TestScene<Real>& scene, Random& random) {
  scene.truth.clear();
  for (const View& view : scene.views) {
    scene.truth.emplace_back(size_t(3 * view.camera.width * view.camera.height));
    for (uint8_t& byte : scene.truth.back()) byte = uint8_t(random.below(256));
  }
}

/// A 3D filter about as large as Gaussians of that size, of none at every third.
inline void add_filter_3d(TestScene<double>& scene, double size, uint64_t seed) {
  Random random(seed);
  for (TestGaussians<double>* set : {&scene.fixed, &scene.moving})
    for (int64_t n = 0; n < set->count; ++n)
      set->filter_size.push_back(n % 3 == 2 ? 0 : random.uniform(0.3 * size, 1.5 * size));
}

/// Rolling shutters, every other one of which reads from the bottom.
inline void set_readouts(TestScene<double>& scene, double readout) {
  for (size_t b = 0; b < scene.views.size(); ++b)
    scene.views[b].camera.readout = b % 2 == 0 ? readout : -readout;
}

inline TestScene<double> random_scene(int64_t fixed, int64_t moving, double size, uint64_t seed,
                                      SetForm form = SetForm::kPair) {
  Random random(seed);
  TestScene<double> scene;
  scene.fixed = random_gaussians(SetForm::kStatic, fixed, 0.9, size, random);
  scene.moving = random_gaussians(form, moving, 0.9, size, random);
  scene.views = three_views();
  scene.options.background[0] = 0.2;
  scene.options.background[2] = 0.7;
  fill_truth(scene, random);
  return scene;
}

}  // namespace tessera::testing
